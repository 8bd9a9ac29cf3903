// A contact law as everything but its force kernel sees it: columns, coefficients, limits, what keys it takes. A law is
// a header in this folder with one constant, its line in laws.cpp and its word in ContactModel; one with a new force
// has that in a header of kernels/models, its word in LawForce and its place in the list of kernels/isa/table.hpp. Who
// asks: keys, rules, the engine; nobody asks which law it is. Invariant: I4 (coefficients are trajectory code).
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "core/rules/contact_limits.hpp"
#include "core/rules/pair_parameters.hpp"
#include "core/scene/scene.hpp"

namespace talus {

/// What the engine has to give to a force.
struct LawInfo {
  const char* name = "";
  LawForce force = LawForce::linear;
  int history = 0;          ///< columns with friction (none without), beside that of recalls()
  unsigned flips = 0;       ///< bit k: column k changes sign when the partners of a contact are swapped
  bool wants_reff = false;  ///< R* of each contact
  bool trial = false;       ///< has a KernelTable::trial

  int slot() const noexcept { return 8 * static_cast<int>(force); }  ///< first of its variants in KernelTable::law
};

/// Overlaps of a grain on a wall [of its radius]: hit at a speed, and under a load.
struct Overlaps {
  double impact = 0, pressed = 0;
};

/// Elastic energy of a contact in normal direction [J], its derivatives by the overlap and by R* [N].
struct StoredEnergy {
  double energy = 0, by_overlap = 0, by_reduced = 0;
};

struct Law {
  ContactModel model;
  std::string_view what;   ///< for `talus help`
  LawInfo force;           ///< of a contact that sticks or slides as a whole
  LawInfo partial_slip{};  ///< with contact.partial_slip; no history: the law has no such force
  /// Stiffness follows from the elastic constants of the materials, which are then required, and grows with the load;
  /// else from contact.normal_stiffness.
  bool by_modulus = false;
  bool balanced = false;       ///< has contact.sliding = "balanced"
  bool weighs_spring = false;  ///< with contact.onset_correction and the memory of recalls(), also without a dashpot
  std::string_view never_clips{};  ///< why contact.clip_tension is refused; empty: it is not
  /// Coefficients of the pair of materials a and b, but for friction.
  PairParameters (*parameters)(const Scene&, int a, int b);
  /// At reduced radius R* [m] and overlap [m]; what grains that change their size do to it is in the balance.
  StoredEnergy (*stored)(const PairParameters&, double reduced, double overlap);
  /// Normal and tangential part of dynamics_of().
  ContactDynamics (*dynamics)(const Scene&, const ContactCase&, const ReducedPair&, double speed, double pressure);
  /// Radius r [m], mass m [kg], speed [m/s], load [N]; and with which power of the stiffness they fall.
  Overlaps (*overlaps)(const Scene&, const Material&, double r, double m, double speed, double load);
  double impact_power, load_power;
  /// Error{scene} where contact.cohesion of the pair outweighs the repulsion; none: the law takes no cohesion.
  void (*judge_cohesion)(const Scene&, int a, int b, double r_max) = nullptr;
  /// adhesion_length() of the pair; none: contacts end with their overlap.
  double (*adhesion)(const Scene&, int a, int b) = nullptr;

  bool slips_in_part() const noexcept { return partial_slip.history > 0; }
};

std::span<const Law* const> contact_laws();
const Law& law_of(ContactModel model);
inline const Law& law_of(const Scene& scene) { return law_of(scene.contact.model); }

/// What the engine needs for the force of a law: the usual one, or what the scene has chosen beside the model.
const LawInfo& law_info(ContactModel model);
const LawInfo& law_info(const ContactLaw& law);

/// "model=a|b" of the laws that `holds` is true for, for the condition of a key; and "a|b" alone.
std::string laws_where(bool (*holds)(const Law&), std::string_view before = "model=");

/// Names of a pair of materials, "glass - steel", for messages.
std::string pair_name(const Scene& scene, int a, int b);

}  // namespace talus
