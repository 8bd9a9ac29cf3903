// What it costs to add one more of a kind, by examples that are there: where a thing is named beside its own line, the
// next one has to be named there, too.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "core/rules/laws/law.hpp"
#include "core/scene/key.hpp"
#include "core/scene/scene.hpp"
#include "scheduler/lists/skin.hpp"
#include "tests/layout/sources.hpp"

namespace talus::layout {
namespace {

std::string joined(const auto& names) {
  std::string s;
  for (const std::string& n : names) s += n + " ";
  return s;
}

/// Folders of files, as "core/scene/sections".
std::set<std::string> folders_of(const std::set<std::string>& files) {
  std::set<std::string> folders;
  for (const std::string& f : files) folders.insert(fs::path(f).parent_path().string());
  return folders;
}

// The files that name an example of each kind are those that the next one touches.
TEST(Cost, InFilesIsPrinted) {
  struct Kind {
    const char* what;
    std::set<std::string> files;
    std::size_t most;
  };
  const auto both = [](std::set<std::string> a, const std::set<std::string>& b) {
    a.insert(b.begin(), b.end());
    return a;
  };
  const Kind kinds[] = {
      {"a contact law (hertz_tsuji)", files_with("hertz_tsuji"), 3},
      {"a force of a law (PartialSlip)", files_with("PartialSlip"), 2},
      {"a list policy (displacement_history)", files_with("displacement_history"), 3},
      {"a wall shape (cone)", both(files_with("WallShape::cone"), files_with("k_cone_shape")), 5},
      {"a key of the scene (onset_correction), less its user", files_with("\"onset_correction\""), 1},
      {"an output quantity (tangential_force)", files_with("\"tangential_force\""), 1},
      {"a part (tracer), its keys and members included", files_with("tracer"), 6},
  };
  std::printf("files touched for one more of a kind\n");
  for (const Kind& k : kinds) {
    std::printf("  %-54s %zu  %s\n", k.what, k.files.size(), joined(k.files).c_str());
    EXPECT_GE(k.files.size(), 1u) << k.what;
    EXPECT_LE(k.files.size(), k.most) << k.what;
  }
}

// A key of a scene: a member of scene.hpp and one line in core/scene/sections.
TEST(Cost, OfAKeyIsOneLine) {
  for (const char* key : {"onset_correction", "lever", "warn_travel", "velocity_jitter", "rotation_rate",
                          "uniform_skin", "viscous", "closed_walls", "stddev"}) {
    const auto lines = lines_with("\"" + std::string(key) + "\"");
    EXPECT_EQ(lines.size(), 1u) << key << " stands at " << joined(lines);
    EXPECT_EQ(folders_of(files_with("\"" + std::string(key) + "\"")), std::set<std::string>{"core/scene/sections"});
  }
}

TALUS_WORDS(Pace, slow, quick)
struct Example {
  double mass = 2.5;
  Pace pace = Pace::quick;
  Vec3 place{0, 1, 0};
  bool held = true;
};

TEST(Cost, OfAKeyIsOneLineThatSaysAllThatHelpAndChecksNeed) {
  const Keys<Example> keys({"example", false, "an example"}, k_free,
                           {
                               key("mass", &Example::mass, "kg", k_positive, "how heavy", "3").fixed("it is stored"),
                               key("pace", &Example::pace, "how fast", "\"slow\"").also({"speed"}),
                               key("place", &Example::place, "m", k_finite, "where", "[1, 2, 3]"),
                               key("held", &Example::held, "whether", "false").required(),
                           });
  const std::vector<SceneKey>& rows = keys.rows();
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[0].type, KeyType::number);
  EXPECT_EQ(rows[0].fallback, "2.5");
  EXPECT_EQ(allowed_text(rows[0]), "a number > 0 [kg]");
  EXPECT_EQ(rows[0].resume.rule, AtResume::fixed);
  EXPECT_EQ(rows[1].fallback, "\"quick\"");
  EXPECT_EQ(allowed_text(rows[1]), "one of slow, quick");
  EXPECT_EQ(rows[1].resume.rule, AtResume::free);
  EXPECT_EQ(rows[1].also.at(0).word, "speed");
  EXPECT_EQ(rows[2].fallback, "[0, 1, 0]");
  EXPECT_TRUE(rows[3].required());
  EXPECT_EQ(full_name(rows[3]), "example.held");
}

// An output quantity: its line, and where it is new data the member that holds it.
TEST(Cost, OfAQuantityIsOneLine) {
  for (const char* quantity : {"tangential_force", "granular_temperature", "solid_fraction", "dissipated_friction",
                               "balance_residual", "plane.<plane>.mass_flow"}) {
    const auto lines = lines_with("\"" + std::string(quantity) + "\"");
    EXPECT_EQ(lines.size(), 1u) << quantity << " stands at " << joined(lines);
  }
}

// A wall shape: its word in WallShape, its keys, its file in core/walls/shapes and its line in shapes.cpp.
TEST(Cost, OfAWallShapeIsAFileAndALine) {
  for (const char* shape : {"plane", "cylinder", "cone", "box", "mesh"}) {
    const std::string name(shape);
    EXPECT_EQ(files_with("WallShape::" + name + ","), (std::set<std::string>{"core/walls/shapes/" + name + ".cpp"}))
        << joined(lines_with("WallShape::" + name));
    EXPECT_EQ(files_with("k_" + name + "_shape"),
              (std::set<std::string>{"core/walls/shapes/" + name + ".cpp", "core/walls/shapes/shape.hpp",
                                     "core/walls/shapes/shapes.cpp"}));
  }
  for (const std::string& folder : folders_of(files_with("WallShape::")))
    EXPECT_TRUE(folder == "core/walls/shapes" || folder == "core/scene/sections" || folder == "core/scene") << folder;
}

// A contact law: its word in ContactModel, its header in core/rules/laws and its line in laws.cpp. hertz_tsuji is one
// whose force is there already; nothing else in the product names it.
TEST(Cost, OfAContactLawIsAHeaderAndALine) {
  EXPECT_EQ(files_with("hertz_tsuji"), (std::set<std::string>{"core/rules/laws/hertz_tsuji.hpp",
                                                              "core/rules/laws/laws.cpp", "core/scene/scene.hpp"}));
  for (const Law* law : contact_laws()) {
    const std::string name(enum_word(law->model));
    // the law itself, the default of a scene; nobody asks which law it is
    std::set<std::string> files = files_with("ContactModel::" + name);
    files.erase("core/scene/scene.hpp");
    EXPECT_EQ(files, std::set<std::string>{"core/rules/laws/" + name + ".hpp"});
    EXPECT_EQ(files_with("laws::k_" + name), std::set<std::string>{"core/rules/laws/laws.cpp"}) << name;
  }
}

// One with a force of its own: that in a header of kernels/models, its word in LawForce, its place in isa/table.hpp.
TEST(Cost, OfAForceIsAHeaderAndALine) {
  EXPECT_EQ(files_with("PartialSlip"),
            (std::set<std::string>{"kernels/isa/table.hpp", "kernels/models/hertz_mindlin.hpp"}));
  EXPECT_EQ(files_with("LawForce::jkr"), std::set<std::string>{"core/rules/laws/jkr.hpp"});
}

/// A law that is nowhere in the product: a spring of twice the given stiffness, without a dashpot.
constexpr Law k_toy{
    .model = ContactModel::linear,
    .what = "a toy",
    .force = {.name = "toy", .force = LawForce::linear, .history = 3, .flips = 0b111},
    .parameters =
        [](const Scene& scene, int, int) {
          PairParameters p;
          p.kn = 2 * scene.contact.normal_stiffness;
          return p;
        },
    .stored =
        [](const PairParameters& p, double, double overlap) {
          return StoredEnergy{0.5 * p.kn * (overlap * overlap), p.kn * overlap, 0};
        },
    .dynamics =
        [](const Scene& scene, const ContactCase&, const ReducedPair& p, double, double) {
          ContactDynamics d;
          d.stiffness = 2 * scene.contact.normal_stiffness;
          d.normal = d.stiffness / p.m;
          d.duration = 3.14159 / std::sqrt(d.normal);
          return d;
        },
    .overlaps = [](const Scene&, const Material&, double, double, double, double) { return Overlaps{}; },
    .impact_power = 0.5,
    .load_power = 1,
};

TEST(Cost, OfAContactLawIsAllThatItSays) {
  Scene scene;
  scene.contact.normal_stiffness = 100;
  EXPECT_EQ(k_toy.parameters(scene, 0, 0).kn, 200);
  EXPECT_EQ(k_toy.dynamics(scene, {}, {.m = 2, .r = 1, .spins = 0}, 0, 0).normal, 100);
  // what it does not say it has not
  EXPECT_FALSE(k_toy.slips_in_part() || k_toy.by_modulus || k_toy.balanced || k_toy.force.wants_reff);
  EXPECT_EQ(k_toy.adhesion, nullptr);
  EXPECT_EQ(k_toy.judge_cohesion, nullptr);
}

// A list policy: its word in ListPolicy, its header in scheduler/lists/policies and its line in policies.cpp. A scene
// that names none gets local or velocity_profile, a frame always; the keys list.interval and list.floor mean fixed and
// paper.
TEST(Cost, OfAListPolicyIsAHeaderAndALine) {
  const std::set<std::string> defaults{"core/scene/scene.cpp", "core/scene/scene.hpp", "core/scene/sections/list.cpp",
                                       "scheduler/view/frame.cpp"};
  for (const Policy* policy : list_policies()) {
    const std::string own = "scheduler/lists/policies/" + policy->name() + ".hpp";
    EXPECT_EQ(files_with("ListPolicy::" + policy->name() + ","), std::set<std::string>{own});
    EXPECT_EQ(files_with("policies::k_" + policy->name()), std::set<std::string>{"scheduler/lists/policies.cpp"});
  }
  for (const std::string& file : files_with("ListPolicy::"))
    EXPECT_TRUE(defaults.count(file) != 0 || file.rfind("scheduler/lists/policies/", 0) == 0) << file;
  EXPECT_EQ(files_with("displacement_history"),
            (std::set<std::string>{"core/scene/scene.hpp", "scheduler/lists/policies.cpp",
                                   "scheduler/lists/policies/displacement_history.hpp"}));
}

/// A policy that is nowhere in the product: no skin but what rows are said to need.
constexpr Policy k_toy_policy{
    .word = ListPolicy::local,
    .guarantee = "a toy",
    .speed = [](SpeedQuery&, Row, const double*, double) { return 0.0; },
};

TEST(Cost, OfAListPolicyIsAllThatItSays) {
  SkinRule rule;
  rule.policy = &k_toy_policy;
  rule.largest = 1e300;
  rule.cap_on = false;
  rule.acceleration_on = k_toy_policy.terms;
  rule.k_dt = 3;
  EXPECT_EQ(rule(0.5, 0.125, 7), 0.125) << "without K the length itself, without an acceleration";
  EXPECT_FALSE(rule.has_k() || rule.drifts() || rule.cuts() || rule.own_check());
  EXPECT_EQ(rule.to_walls(0.25), 0.25);
  EXPECT_EQ(k_toy_policy.prepare, nullptr);
}

// How many sources are compiled again after a change of each kind (the script prints the table).
TEST(Cost, OfAChangeIsFewRecompiledSources) {
  EXPECT_EQ(
      std::system("PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 " TALUS_SOURCE_DIR "/tests/layout/recompiles.py --check"),
      0);
}

}  // namespace
}  // namespace talus::layout
