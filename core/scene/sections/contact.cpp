// [contact] and [[pair]]: the contact law and its coefficients per pair of materials.
#include "core/rules/laws/law.hpp"
#include "core/scene/sections/sections.hpp"

namespace talus {
namespace {

constexpr std::string_view k_history = "it decides what the stored contact history means";

// What the laws say of themselves (core/rules/laws), as conditions and text of keys.
const std::string k_by_stiffness = laws_where([](const Law& l) { return !l.by_modulus; });
const std::string k_stiffness_words = laws_where([](const Law& l) { return !l.by_modulus; }, "");
const std::string k_clips = laws_where([](const Law& l) { return l.never_clips.empty(); });
const std::string k_balanced = laws_where([](const Law& l) { return l.balanced; });
const std::string k_slips_in_part = laws_where([](const Law& l) { return l.slips_in_part(); });
const std::string k_coheres = laws_where([](const Law& l) { return l.judge_cohesion != nullptr; });
const std::string k_adheres = laws_where([](const Law& l) { return l.adhesion != nullptr; });

std::string text_of_laws() {
  std::string text;
  for (const Law* law : contact_laws())
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", enum_word(law->model), law->what);
  return text;
}
const std::string k_laws = text_of_laws();

/// [contact] holds the law and the coefficients of all pairs that have none of their own.
struct Contact : ContactLaw, PairCoefficients {};

const Keys<Contact> k_contact(
    {"contact", false, "contact law and its coefficients for all pairs of materials"}, k_acts,
    {
        key("model", &ContactLaw::model, k_laws, "\"linear\"")
            .fixed(k_history)
            .also({"law"})
            .meaning({{"hooke", "linear"},
                      {"spring", "linear"},
                      {"lsd", "linear"},
                      {"hertzian", "hertz_mindlin"},
                      {"adhesive", "jkr"},
                      {"johnson", "jkr"}}),
        other_key<Contact>("friction", KeyType::number_or_none, "-", {0, 1e6},
                           "Coulomb coefficient; none or 0 for all pairs: no tangential force, history or rotation",
                           "0.5")
            .absent("\"none\"")
            .also({"mu", "coulomb", "cof", "friction_coefficient", "sliding_friction", "static_friction"}),
        key("restitution", &PairCoefficients::restitution, "-", {0, 1, true},
            "normal restitution; either this or normal_damping", "0.8")
            .absent("(none; the Hertz models require it)")
            .also({"e", "cor", "coefficient_of_restitution", "en"}),
        key("normal_stiffness", &ContactLaw::normal_stiffness, "N/m", k_positive, "spring in normal direction", "1e5")
            .only(k_by_stiffness)
            .needed(k_stiffness_words, "(required by linear)")
            .also({"kn", "k_n", "stiffness", "spring"}),
        key("tangential_stiffness", &ContactLaw::tangential_stiffness, "N/m", k_not_negative,
            "spring in tangential direction", "3e4")
            .only(k_by_stiffness)
            .absent("(2/7 of normal_stiffness)")
            .also({"kt", "k_t", "shear_stiffness"}),
        key("normal_damping", &ContactLaw::normal_damping, "1/s", k_not_negative,
            "normal damping rate g: force = g m_eff v; either this or restitution", "50")
            .only(k_by_stiffness)
            .also({"gamma_n", "gamman", {"damping", "contact"}}),
        key("tangential_damping", &ContactLaw::tangential_damping, "1/s", k_not_negative,
            "tangential damping rate g: force = g m_eff v", "25")
            .only(k_by_stiffness)
            .also({"gamma_t", "gammat"}),
        key("dashpot", &ContactLaw::dashpot,
            "velocity in the dashpot: centred in time (second order), the same with the forces of the pair alone "
            "(second order in impacts, soft at rest under load), or of the last half step (first order, as other "
            "codes)",
            "\"lagged\"")
            .fixed(k_history),
        key("onset_correction", &ContactLaw::onset_correction,
            "weigh the dashpot (linear law: and the spring) by the touching fraction of the first and last step of a "
            "contact",
            "false")
            .fixed(k_history),
        key("clip_tension", &ContactLaw::clip_tension,
            "the normal force never pulls (the dashpot would, towards the end of a contact); damping from a "
            "restitution is chosen so that clipped impacts have it",
            "true")
            .only(k_clips),
        key("synchronised", &ContactLaw::synchronised,
            "tangential history in the mid-step frame: no sticking at large size ratios", "false")
            .fixed(k_history),
        key("lever", &ContactLaw::lever,
            "lever of the tangential force: to the contact point (conserves angular momentum) or the full radius",
            "\"radius\""),
        key("sliding", &ContactLaw::sliding,
            "tangential spring of a sliding contact; series: spring and dashpot side by side, in series with the "
            "slider (converges with the step, never yields energy); balanced: the scaled force less the dashpot (may "
            "load the spring backwards, as LAMMPS)",
            "\"balanced\"")
            .only(k_balanced)
            .fixed(k_history),
        key("friction_limit", &ContactLaw::friction_limit,
            "normal force N in |F_t| <= mu N; elastic: without the dashpot's part, which sums to nothing over an "
            "impact, so that a sliding impact has the impulse J_t = mu J_n; total: max(F_n, 0), as other codes, which "
            "takes more than mu J_n where the dashpot pulls; with clip_tension always total",
            "\"total\""),
        key("partial_slip", &ContactLaw::partial_slip,
            "Mindlin's micro-slip: two rings of the contact area stick, slip and part each by itself, so that spins "
            "after impacts at small angles are within 10 % of finite elements (one spring for the whole contact, which "
            "shrinks with it: 45 %); needs friction; three more history columns per contact",
            "true")
            .only(k_slips_in_part)
            .fixed(k_history)
            .with("friction = 0.5\nrestitution = 0.8\n"),
        key("rolling", &ContactLaw::rolling,
            "rolling resistance; cdt: constant moment against the spin; epsd: spring, dashpot and slider (rests "
            "without creep)",
            "\"epsd\"")
            .fixed(k_history)
            .meaning({{"constant", "cdt"},
                      {"spring", "epsd"},
                      {"elastic", "epsd"},
                      {"off", "none"},
                      {"no", "none"},
                      {"free", "none"}})
            .with("friction = 0.5\nrolling_friction = 0.1\n"),
        key("rolling_friction", &PairCoefficients::rolling_friction, "-", {0, 100}, "mu_r in moment <= mu_r R* F_n",
            "0.1")
            .only("rolling=cdt|epsd")
            .also({"mu_r", "rolling_resistance"})
            .with("friction = 0.5\nrolling = \"cdt\"\n"),
        other_key<Contact>("rolling_damping", KeyType::number, "-", {0, 10},
                           "damping ratio of the rolling spring; acts below the limit only", "0.5")
            .only("rolling=epsd")
            .absent("0.3")
            .with("friction = 0.5\nrolling_friction = 0.1\nrolling = \"epsd\"\n"),
        key("twisting_friction", &PairCoefficients::twisting_friction, "-", {0, 100},
            "mu_t in moment about the normal <= mu_t R* F_n; 0 for all pairs: no twisting resistance", "0.05")
            .also({"mu_t"})
            .with("friction = 0.5\n"),
        key("twisting_damping", &PairCoefficients::twisting_damping, "-", {0, 10},
            "damping ratio of the twisting spring; acts below the limit only", "0.5")
            .absent("0.3")
            .with("friction = 0.5\ntwisting_friction = 0.05\n"),
        key("cohesion", &ContactLaw::cohesion, "sjkr: attraction = cohesion_energy * contact area, while in touch",
            "\"sjkr\"")
            .only(k_coheres)
            .fixed(k_history)
            .with("cohesion_energy = 1e3\n"),
        key("cohesion_energy", &PairCoefficients::cohesion_energy, "J/m3", k_not_negative,
            "cohesion energy density: attraction per contact area", "1e3")
            .only("cohesion=sjkr")
            .with("cohesion = \"sjkr\"\n"),
        key("work_of_adhesion", &PairCoefficients::work_of_adhesion, "J/m2", k_not_negative,
            "w of a pair of surfaces, 2 gamma of like ones; pull-off force 3/2 pi w R*", "0.05")
            .only(k_adheres)
            .with("model = \"jkr\"\n"),
    });

/// Each line of a coefficient names that of [contact] as what holds without it.
const Keys<PairCoefficients> k_pair(
    {"pair", true, "coefficients of one pair of materials, in place of those of [contact]"}, k_acts,
    {
        other_key<PairCoefficients>("materials", KeyType::text_pair, "", {0, 0}, "the two materials, in any order",
                                    "[\"glass\", \"steel\"]")
            .required(),
        other_key<PairCoefficients>("friction", KeyType::number_or_none, "-", {0, 1e6}, "Coulomb coefficient", "0.3")
            .absent("(contact.friction)"),
        key("restitution", &PairCoefficients::restitution, "-", {0, 1, true}, "normal restitution", "0.7")
            .absent("(contact.restitution)")
            .with("restitution = 0.8\n"),
        key("rolling_friction", &PairCoefficients::rolling_friction, "-", {0, 100},
            "rolling friction; needs contact.rolling", "0.2")
            .absent("(contact.rolling_friction)")
            .with("friction = 0.5\nrolling = \"cdt\"\n"),
        key("rolling_damping", &PairCoefficients::rolling_damping, "-", {0, 10},
            "damping ratio of the rolling spring; needs contact.rolling = epsd", "0.5")
            .absent("(contact.rolling_damping)")
            .with("friction = 0.5\nrolling_friction = 0.1\nrolling = \"epsd\"\n"),
        key("twisting_friction", &PairCoefficients::twisting_friction, "-", {0, 100}, "twisting friction", "0.02")
            .absent("(contact.twisting_friction)")
            .with("friction = 0.5\n"),
        key("twisting_damping", &PairCoefficients::twisting_damping, "-", {0, 10},
            "damping ratio of the twisting spring", "0.5")
            .absent("(contact.twisting_damping)")
            .with("friction = 0.5\ntwisting_friction = 0.05\n"),
        key("cohesion_energy", &PairCoefficients::cohesion_energy, "J/m3", k_not_negative,
            "cohesion energy density; needs contact.cohesion = sjkr", "500")
            .absent("(contact.cohesion_energy)")
            .with("cohesion = \"sjkr\"\n"),
        key("work_of_adhesion", &PairCoefficients::work_of_adhesion, "J/m2", k_not_negative,
            "work of adhesion; needs contact.model = jkr", "0.02")
            .absent("(contact.work_of_adhesion)")
            .with("model = \"jkr\"\n"),
    });

/// Friction of a section: absent -> fallback, "none" -> 0.
double read_friction(const SceneTable& r, double fallback) {
  return r.has("friction") ? r.number_or_text("friction").value_or(0) : fallback;
}

/// Coefficients of the pairs: those of [contact], then those of each [[pair]]. Returns whether a restitution is given.
bool read_pairs(const SceneTable& r, const std::vector<SceneTable>& pairs, const std::vector<std::string>& names,
                const PairCoefficients& general, Scene& scene) {
  const std::size_t n = names.size();
  scene.pairs.assign(n * n, general);
  bool any_restitution = r.has("restitution");
  std::vector<char> seen(n * n);
  for (const SceneTable& p : pairs) {
    const auto a = static_cast<std::size_t>(p.index("materials", names, "material", 0));
    const auto b = static_cast<std::size_t>(p.index("materials", names, "material", 1));
    if (seen[a * n + b]) p.fail("materials", "this pair is given twice");
    seen[a * n + b] = seen[b * n + a] = 1;
    PairCoefficients& k = scene.pairs[a * n + b];
    k_pair.read(p, k);
    k.friction = read_friction(p, k.friction);
    any_restitution = any_restitution || p.has("restitution");
    if (p.has("restitution") && r.has("normal_damping"))
      p.fail("restitution", "contradicts 'contact.normal_damping'; give one of the two");
    scene.pairs[b * n + a] = k;
  }
  return any_restitution;
}

/// Coefficients of a pair that an addition has to have.
void check_pair(const SceneTable& p, const ContactLaw& c) {
  if (p.has("rolling_friction") && c.rolling == Rolling::none)
    p.fail("rolling_friction", "has no effect without contact.rolling");
  if (p.has("rolling_damping") && c.rolling != Rolling::epsd)
    p.fail("rolling_damping", "has no effect without contact.rolling = epsd");
  if (p.has("twisting_damping") && !c.twisting)
    p.fail("twisting_damping", "has no effect without twisting_friction > 0");
  if (p.has("cohesion_energy") && c.cohesion == Cohesion::none)
    p.fail("cohesion_energy", "has no effect without contact.cohesion");
  if (p.has("work_of_adhesion") && law_of(c.model).adhesion == nullptr)
    p.fail("work_of_adhesion", "has no effect without contact.model = jkr");
}

/// What an addition needs of the law, and that it does something.
void check_add_ons(const SceneTable& r, const std::vector<SceneTable>& pairs, Scene& scene) {
  ContactLaw& c = scene.contact;
  double rolling = 0, twisting = 0, cohesion = 0, adhesion = 0;
  for (const PairCoefficients& k : scene.pairs) {
    rolling = fmax2(rolling, k.rolling_friction);
    twisting = fmax2(twisting, k.twisting_friction);
    cohesion = fmax2(cohesion, k.cohesion_energy);
    adhesion = fmax2(adhesion, k.work_of_adhesion);
  }
  c.twisting = twisting > 0;
  if (c.rolling != Rolling::none && !c.friction)
    r.fail("rolling", "needs contact.friction > 0: without friction no grain rotates");
  if (c.twisting && !c.friction) {
    const char* why = "needs contact.friction > 0: without friction no grain rotates";
    if (r.has("twisting_friction")) r.fail("twisting_friction", why);
    for (const SceneTable& p : pairs)
      if (p.has("twisting_friction")) p.fail("twisting_friction", why);
  }
  if (!c.twisting && r.has("twisting_damping"))
    r.fail("twisting_damping", "has no effect without twisting_friction > 0");
  if (c.rolling != Rolling::none && rolling == 0)
    r.missing("rolling_friction", "(> 0 for some pair) by contact.rolling");
  if (c.cohesion != Cohesion::none && cohesion == 0)
    r.missing("cohesion_energy", "(> 0 for some pair) by contact.cohesion");
  if (law_of(c.model).adhesion != nullptr && adhesion == 0)
    r.missing("work_of_adhesion", fmt::format("(> 0 for some pair) by contact.model = {}", enum_word(c.model)));
  for (const SceneTable& p : pairs) check_pair(p, c);
}

}  // namespace

const SectionKeys& contact_keys() { return k_contact; }
const SectionKeys& pair_keys() { return k_pair; }

void read_contact(const SceneTable& r, const std::vector<SceneTable>& pairs, const std::vector<SceneTable>& materials,
                  const std::vector<std::string>& names, Scene& scene) {
  Contact contact;
  k_contact.read(r, contact);
  PairCoefficients& general = contact;
  general.friction = read_friction(r, 0);
  general.rolling_damping = contact.rolling == Rolling::epsd ? r.number("rolling_damping") : 0;
  ContactLaw& c = scene.contact = contact;
  const bool any_restitution = read_pairs(r, pairs, names, general, scene);
  c.friction = false;
  for (const PairCoefficients& k : scene.pairs) c.friction = c.friction || k.friction > 0;
  check_add_ons(r, pairs, scene);
  if (c.partial_slip && !c.friction) r.fail("partial_slip", "has no effect without contact.friction > 0");
  const Law& law = law_of(c.model);
  if (c.clip_tension && c.cohesion != Cohesion::none)
    r.fail("clip_tension", "contradicts adhesion and cohesion, which pull");
  if (c.clip_tension && !law.never_clips.empty()) r.fail("clip_tension", std::string(law.never_clips));

  if (!law.by_modulus) {
    r.exclusive("restitution", "normal_damping");
    if (!r.has("tangential_stiffness")) c.tangential_stiffness = 2.0 / 7.0 * c.normal_stiffness;
    c.by_restitution = any_restitution;
  } else {
    for (const SceneTable& m : materials) {
      m.require("young", "by the Hertz models");
      m.require("poisson", "by the Hertz models");
    }
  }
  if (law.by_modulus || c.by_restitution) {
    for (const PairCoefficients& k : scene.pairs) {
      if (k.restitution < 0) r.missing("restitution", "because some pair of materials has none of its own");
    }
  }
}

}  // namespace talus
