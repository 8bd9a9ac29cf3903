// Suggestions for keys that do not exist: by spelling, by place, and by what words mean elsewhere.
#include "core/scene/scene_suggest.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace talus {
namespace {

std::string suggested(const std::string& path) {
  const KeySuggestion s = suggest_key(path);
  return s.key != nullptr ? full_name(*s.key) : "";
}

TEST(SuggestKey, LooksAtTheWholePathAndAtTheMeaning) {
  const std::vector<std::pair<std::string, std::string>> meant{
      {"friction", "contact.friction"},
      {"contact.frictoin", "contact.friction"},
      {"mu", "contact.friction"},
      {"contact.mu", "contact.friction"},
      {"contact.friction_coefficient", "contact.friction"},
      {"pair.0.fricton", "pair.friction"},
      {"size.radius", "source.size.diameter"},
      {"source.0.size.radius", "source.size.diameter"},
      {"source.1.radius", "source.size.diameter"},
      {"radius", "source.size.diameter"},
      {"wall.2.raduis", "wall.radius"},
      {"source.region.raduis", "source.region.radius"},
      {"source.0.size.sigma", "source.size.stddev"},
      {"gravty", "gravity"},
      {"g", "gravity"},
      {"Gravity", "gravity"},
      {"dt", "time.step"},
      {"time.timestep", "time.step"},
      {"time.end_time", "time.duration"},
      {"duration", "time.duration"},
      {"rho", "material.density"},
      {"contact.youngs_modulus", "material.young"},
      {"contact.young", "material.young"},
      {"material.0.poisons", "material.poisson"},
      {"contact.stiffness", "contact.normal_stiffness"},
      {"contact.kn", "contact.normal_stiffness"},
      {"contact.cor", "contact.restitution"},
      {"contact.damping", "contact.normal_damping"},
      {"domain.periodic", "domain.boundary"},
      {"domain.min", "domain.lower"},
      {"source.0.count", "source.number"},
      {"wall.0.motion.omega", "wall.motion.rotation_rate"},
      {"wall.0.rotation_rate", "wall.motion.rotation_rate"},
      {"wall.stl", "wall.file"},
      {"output.vtk", "output.vtp"},
      {"output.every", "output.particles_every"},
      {"output.csv", "output.csv_every"},
      {"checkpoint_every", "output.checkpoint_wall"},
      {"list.k", "list.verlet_k"},
      {"contact.normal-stiffness", "contact.normal_stiffness"},
      {"qqqqq", ""},
      {"x", "laser.x"},
      {"q", ""},
      {"", ""},
      {"....", ""},
  };
  for (const auto& [typed, expected] : meant) EXPECT_EQ(suggested(typed), expected) << typed;
}

TEST(SuggestKey, EveryKeyWithAWrongLetterOrTwoSwappedIsFoundAgainInItsSection) {
  for (const SceneKey& key : scene_keys()) {
    if (key.name.size() < 5) continue;
    std::string wrong = full_name(key), swapped = wrong;
    wrong[wrong.size() - 3] = 'q';
    std::swap(swapped[swapped.size() - 2], swapped[swapped.size() - 3]);
    EXPECT_EQ(suggested(wrong), full_name(key));
    EXPECT_EQ(suggested(swapped), full_name(key)) << swapped;
  }
}

std::string choice_for(const char* section, const char* name, const char* word) {
  const SceneKey* key = find_scene_key(section, name);
  if (key == nullptr) return "no such key";
  std::vector<std::string> words;
  for (const std::string_view w : split_words(key->choices, ", ")) words.emplace_back(w);
  return choice_hint(word, words, key->meanings);
}

TEST(ChoiceHint, LooksAtTheMeaningFirstAndAtLettersOnlyWhereFewAreWrong) {
  struct {
    const char *section, *name, *word, *meant;
  } const cases[] = {
      {"source.size", "kind", "single", "constant"},
      {"source.size", "kind", "Monodisperse", "constant"},
      {"source.size", "kind", "gaussian", "normal"},
      {"source.size", "kind", "log-normal", "lognormal"},
      {"source.size", "kind", "histogram", "sieve"},
      {"source.size", "kind", "sive", "sieve"},
      {"contact", "model", "hertz", "hertz_mindlin"},
      {"contact", "model", "tsuji", "hertz_tsuji"},
      {"contact", "model", "hooke", "linear"},
      {"contact", "model", "linear_spring", "linear"},
      {"contact", "model", "Hertz-Mindlin", "hertz_mindlin"},
      {"contact", "model", "JKR", "jkr"},
      {"contact", "rolling", "off", "none"},
      {"domain", "boundary", "perodic", "periodic"},
      {"domain", "boundary", "reflect", "wall"},
      {"wall", "shape", "floor", "plane"},
      {"wall", "shape", "pipe", "cylinder"},
      {"wall", "shape", "STL", "mesh"},
      {"event", "action", "delete", "remove"},
      {"source", "kind", "rain", "stream"},
      {"", "integrator", "verlet", "velocity_verlet"},
      {"source.region", "shape", "ball", "sphere"},
      {"source.size", "kind", "zzzzzz", ""},
      {"source.size", "kind", "signed", ""},
      {"wall", "shape", "torus", ""},
      {"contact", "model", "", ""},
  };
  for (const auto& c : cases) {
    const std::string hint = choice_for(c.section, c.name, c.word), meant = c.meant;
    EXPECT_EQ(hint, meant.empty() ? "" : " (did you mean '" + meant + "'?)")
        << c.section << "." << c.name << " = " << c.word;
  }
}

TEST(ChoiceHint, EveryMeaningIsOneOfTheChoicesAndNoChoiceItself) {
  int seen = 0;
  for (const SceneKey& key : scene_keys())
    for (const Meaning& m : key.meanings) {
      const auto words = split_words(key.choices, ", ");
      const auto is_one = [&](std::string_view w) { return std::find(words.begin(), words.end(), w) != words.end(); };
      EXPECT_TRUE(is_one(m.choice)) << full_name(key) << ": " << m.choice;
      EXPECT_FALSE(is_one(m.word)) << full_name(key) << ": " << m.word;
      ++seen;
    }
  EXPECT_GT(seen, 50);
}

TEST(SuggestKey, AliasesNameKeysThatExist) {
  // An alias of a key that is renamed would silently suggest nothing.
  for (const char* typed : {"particle_radius", "k_t", "gamma_n", "mu_r", "mu_t", "random_seed", "nsteps", "nu", "hdf5",
                            "dump_every", "rpm", "law"})
    EXPECT_NE(suggested(typed), "") << typed;
}

TEST(SettablePath, KeepsIndicesAndFillsMissingOnes) {
  const SceneKey* diameter = find_scene_key("source.size", "diameter");
  ASSERT_NE(diameter, nullptr);
  EXPECT_EQ(settable_path(*diameter, "size.radius"), "source.0.size.diameter");
  EXPECT_EQ(settable_path(*diameter, "source.3.size.radius"), "source.3.size.diameter");
  EXPECT_EQ(settable_path(*find_scene_key("", "gravity"), "gravty"), "gravity");
  EXPECT_EQ(settable_path(*find_scene_key("output.plane", "point"), "output.plane.point"), "output.plane.0.point");
}

TEST(NearestName, CountsSwapsOnceAndFindsWords) {
  EXPECT_EQ(edit_distance("runn", "run"), 1u);
  EXPECT_EQ(edit_distance("chekc", "check"), 1u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("Verlet-K", "verlet_k"), 0u);
  const std::vector<std::string> names{"--out", "--threads", "--checkpoint-every", "--set"};
  EXPECT_EQ(nearest_name("--thread", names), "--threads");
  EXPECT_EQ(nearest_name("--every", names), "--checkpoint-every");
  EXPECT_EQ(nearest_name("zzzzzzzz", names), "");
  EXPECT_EQ(nearest_name("", names), "");
}

}  // namespace
}  // namespace talus
