// One contact driven along a prescribed path, straight through the kernels: what a test needs to measure work and
// objectivity without any inertia. Who calls it: tests/physics. Invariant: position x is that of step n, velocity and
// spin those of n-1/2, as the engine hands them over.
#pragma once

#include <vector>

#include "core/base/types.hpp"
#include "core/scene/scene.hpp"
#include "kernels/kernel_table.hpp"

namespace talus::physics {

class KernelContact {
 public:
  struct Result {
    Vec3 force;                                     ///< on i [N]
    double elastic = 0, damping = 0, friction = 0;  ///< stored [J], lost in this step [J]
  };

  /// Two spheres of radii r_i, r_j and the masses that the scene's first material gives them.
  KernelContact(const Scene& scene, double r_i, double r_j, double inverse_mass, Isa isa = Isa::automatic)
      : table_(select_kernels(isa)), parameters_(pair_parameters(scene)), sum_(r_i + r_j), inverse_mass_(inverse_mass) {
    const LawInfo& law = law_info(scene.contact);
    law_ = table_.law[law_index(law, true, false, true)];
    args_.one = parameters_[0];
    args_.table = parameters_.data();
    args_.dt = scene.dt;
    args_.by_restitution = scene.contact.by_restitution ? 1 : 0;
    args_.centred = scene.contact.dashpot != Dashpot::lagged ? 1 : 0;
    args_.onset = scene.contact.onset_correction ? 1 : 0;
    args_.synchronised = scene.contact.synchronised ? 1 : 0;
    args_.contact_lever = scene.contact.lever == Lever::contact ? 1 : 0;
    for (int k = 0; k < k_size; ++k) {
      reff_[k] = r_i * r_j / (r_i + r_j);
      pair_[k] = 0;
      for (auto& h : h_) h[k] = 0;
    }
  }

  /// Centre difference x = x_i - x_j at n, relative velocity and r_i w_i + r_j w_j at n-1/2.
  Result step(Vec3 x, Vec3 v, Vec3 spin) {
    for (int k = 0; k < k_size; ++k) {
      x_[0][k] = x.x;
      x_[1][k] = x.y;
      x_[2][k] = x.z;
      w_[k] = sum_;
      for (int q = 0; q < 3; ++q) {
        r_[q][k] = v[q];
        r_[4 + q][k] = spin[q];
      }
      r_[3][k] = 0;
      r_[7][k] = inverse_mass_;
    }
    Block b{};
    b.n = 1;
    b.x = x_[0];
    b.y = x_[1];
    b.z = x_[2];
    b.w = w_;
    table_.geometry(GeometryArgs{1, x_[0], x_[1], x_[2], w_, r_[7], g_});
    b.g = g_;
    b.r = r_;
    for (int q = 0; q < k_max_history; ++q) b.h_in[q] = b.h[q] = h_[q];
    b.reff = reff_;
    b.pair = pair_;
    b.e = e_;
    law_(b, args_);
    return {{r_[0][0], r_[1][0], r_[2][0]}, e_[0][0], e_[1][0], e_[2][0]};
  }

 private:
  static constexpr int k_size = k_block + k_pad;
  const KernelTable& table_;
  std::vector<PairParameters> parameters_;
  void (*law_)(Block&, const LawArgs&) = nullptr;
  LawArgs args_{};
  double sum_, inverse_mass_;
  alignas(64) double x_[3][k_size] = {}, w_[k_size] = {}, reff_[k_size] = {};
  alignas(64) double r_[8][k_size] = {}, g_[4][k_size] = {}, e_[3][k_size] = {}, h_[k_max_history][k_size] = {};
  alignas(64) std::int32_t pair_[k_size] = {};
};

}  // namespace talus::physics
