// Every target on its corpus and on some thousand mutations of it, in every test run: targets do not rot, and what was
// found once stays mended. The long runs are those of libFuzzer (tests/fuzz/README.md).
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "core/rng.hpp"
#include "paths.hpp"
#include "tests/fuzz/targets.hpp"

namespace talus::fuzz {
namespace {

using Input = std::vector<std::uint8_t>;

std::vector<Input> corpus(const std::string& target) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(TALUS_SOURCE_DIR) / "tests" /
                                                               "fuzz" / "corpus" / target))
    files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<Input> inputs;
  for (const auto& file : files) {
    std::ifstream in(file, std::ios::binary);
    inputs.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  return inputs;
}

/// Flips, overwrites, inserts, removes and repeats some bytes.
Input mutated(Input b, const CounterRng& rng, std::uint64_t& draw) {
  const auto below = [&](std::size_t n) { return n == 0 ? 0 : static_cast<std::size_t>(rng.bits(draw++) % n); };
  for (std::size_t times = 1 + below(4); times > 0; --times) {
    const auto at = static_cast<std::ptrdiff_t>(below(b.size()));
    const auto value = static_cast<std::uint8_t>(rng.bits(draw++));
    switch (below(5)) {
      case 0:
        if (!b.empty()) b[static_cast<std::size_t>(at)] ^= static_cast<std::uint8_t>(1U << (value % 8));
        break;
      case 1:
        if (!b.empty()) b[static_cast<std::size_t>(at)] = value;
        break;
      case 2:
        b.insert(b.begin() + at, value);
        break;
      case 3:
        if (!b.empty())
          b.erase(b.begin() + at,
                  b.begin() + at +
                      static_cast<std::ptrdiff_t>(
                          1 + below(std::min<std::size_t>(8, b.size() - static_cast<std::size_t>(at)))));
        break;
      default:
        if (!b.empty()) {
          const Input piece(b.begin() + at, b.begin() + at +
                                                static_cast<std::ptrdiff_t>(std::min<std::size_t>(
                                                    16, b.size() - static_cast<std::size_t>(at))));
          b.insert(b.begin() + static_cast<std::ptrdiff_t>(below(b.size())), piece.begin(), piece.end());
        }
    }
  }
  return b;
}

class Fuzz : public testing::TestWithParam<Target> {};

TEST_P(Fuzz, CorpusAndMutationsOfItEndInAnAnswer) {
  const Target target = GetParam();
  const std::vector<Input> inputs = corpus(target.name);
  ASSERT_FALSE(inputs.empty());
  const CounterRng rng(11, 5, 0);
  std::uint64_t draw = 0;
  const int mutations = std::string(target.name) == "checkpoint" ? 300 : 3000;
  for (const Input& input : inputs) target.run(input);
  for (int k = 0; k < mutations; ++k)
    target.run(mutated(inputs[static_cast<std::size_t>(k) % inputs.size()], rng, draw));
}

INSTANTIATE_TEST_SUITE_P(Targets, Fuzz, testing::ValuesIn(k_targets), [](const auto& t) { return t.param.name; });

}  // namespace
}  // namespace talus::fuzz
