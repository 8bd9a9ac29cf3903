// Every target on its corpus and on some mutations of it, in every test run: targets do not rot, and what was found
// once stays mended. TALUS_FULL=1 tries a million mutations of each; the runs that look for new code are those of
// libFuzzer (tests/fuzz/README.md).
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "core/base/rng.hpp"
#include "paths.hpp"
#include "tests/fuzz/targets.hpp"

namespace talus::fuzz {
namespace {

using Input = std::vector<std::uint8_t>;

struct Case {
  std::string name;
  Input bytes;
};

std::vector<Case> corpus(const std::string& target) {
  namespace fs = std::filesystem;
  std::vector<Case> cases;
  for (const auto& entry : fs::directory_iterator(fs::path(TALUS_SOURCE_DIR) / "tests/fuzz/corpus" / target)) {
    std::ifstream in(entry.path(), std::ios::binary);
    cases.push_back({entry.path().filename().string(), {std::istreambuf_iterator<char>(in), {}}});
  }
  std::sort(cases.begin(), cases.end(), [](const Case& a, const Case& b) { return a.name < b.name; });
  return cases;
}

void expect_answer(const Target& target, const Input& input, const std::string& what) {
  try {
    target.run(input);
  } catch (const std::exception& e) {
    ADD_FAILURE() << target.name << ", " << what << ": " << e.what();
  }
}

/// One to four changes: a byte flipped, replaced, inserted or removed, a piece repeated elsewhere.
Input mutated(Input b, const CounterRng& rng, std::uint64_t& draw) {
  const auto below = [&](std::size_t n) { return static_cast<std::ptrdiff_t>(rng.bits(draw++) % n); };
  for (auto times = 1 + below(4); times > 0 && !b.empty(); --times) {
    const auto at = b.begin() + below(b.size());
    const auto value = static_cast<std::uint8_t>(rng.bits(draw++));
    const auto piece = std::min<std::ptrdiff_t>(b.end() - at, 1 + value % 16);
    switch (below(5)) {
      case 0:
        *at ^= static_cast<std::uint8_t>(1U << (value % 8));
        break;
      case 1:
        *at = value;
        break;
      case 2:
        b.insert(at, value);
        break;
      case 3:
        b.erase(at, at + piece);
        break;
      default: {
        const Input copy(at, at + piece);
        b.insert(b.begin() + below(b.size()), copy.begin(), copy.end());
      }
    }
  }
  return b;
}

class Fuzz : public testing::TestWithParam<Target> {};

TEST_P(Fuzz, CorpusAndMutationsOfItEndInAnAnswer) {
  const Target target = GetParam();
  const std::vector<Case> cases = corpus(target.name);
  ASSERT_FALSE(cases.empty());
  for (const Case& c : cases) expect_answer(target, c.bytes, c.name);
  const CounterRng rng(11, 5, 0);
  std::uint64_t draw = 0;
  const int mutations = std::getenv("TALUS_FULL") != nullptr ? 1000000 : 500;
  for (int k = 0; k < mutations; ++k) {
    const Case& c = cases[static_cast<std::size_t>(k) % cases.size()];
    expect_answer(target, mutated(c.bytes, rng, draw), c.name + ", mutation " + std::to_string(k));
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, Fuzz, testing::ValuesIn(k_targets), [](const auto& t) { return t.param.name; });

}  // namespace
}  // namespace talus::fuzz
