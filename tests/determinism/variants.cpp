// Levels of the factors and their covers.
#include "tests/determinism/variants.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <tuple>

#include "kernels/kernel_table.hpp"
#include "scheduler/lists/skin.hpp"

namespace talus::determinism {
namespace {

const std::vector<double> k_verlet = {0, 1, 10, 50, 200, 1000, 5000, k_auto};
const std::vector<int> k_threads = {1, 2, 3, 8};
const std::vector<int> k_chunks = {64, 257, 0};

using Pair = std::tuple<int, int, int, int>;  // factor, level, factor, level

std::set<Pair> all_pairs(const Levels& counts) {
  std::set<Pair> pairs;
  for (int f = 0; f < k_factors; ++f)
    for (int g = f + 1; g < k_factors; ++g)
      for (int a = 0; a < counts[static_cast<std::size_t>(f)]; ++a)
        for (int b = 0; b < counts[static_cast<std::size_t>(g)]; ++b) pairs.insert({f, a, g, b});
  return pairs;
}

template <class F>
void for_pairs(const Levels& row, F use) {
  for (int f = 0; f < k_factors; ++f)
    for (int g = f + 1; g < k_factors; ++g)
      use(Pair{f, row[static_cast<std::size_t>(f)], g, row[static_cast<std::size_t>(g)]});
}

}  // namespace

const std::vector<ListPolicy>& exact_policies() {
  static const std::vector<ListPolicy> all = [] {
    std::vector<ListPolicy> found;
    for (const Policy* p : list_policies())
      if (p->word != ListPolicy::fixed) found.push_back(p->word);
    return found;
  }();
  return all;
}

std::string Variant::text() const {
  char line[128];
  std::snprintf(line, sizeof line, "%s K=%g threads=%d chunk=%d isa=%s", policy_of(policy).name().c_str(), k, threads,
                chunk, isa_name(isa));
  return line;
}

Scene Variant::apply(Scene scene) const {
  scene.list.policy = policy;
  scene.list.automatic = k == k_auto;
  scene.list.verlet_k = k == k_auto ? 200 : k;
  return scene;
}

RunOptions Variant::options() const {
  RunOptions o;
  o.threads = threads;
  o.chunk = chunk;
  o.isa = isa;
  return o;
}

Levels level_counts() {
  return {static_cast<int>(exact_policies().size()), static_cast<int>(k_verlet.size()),
          static_cast<int>(k_threads.size()), static_cast<int>(k_chunks.size()),
          static_cast<int>(available_isas().size())};
}

Variant variant_of(const Levels& l) {
  const auto at = [&](int f) { return static_cast<std::size_t>(l[static_cast<std::size_t>(f)]); };
  return {exact_policies()[at(0)], k_verlet[at(1)], k_threads[at(2)], k_chunks[at(3)], available_isas()[at(4)]};
}

std::vector<Levels> full_product(const Levels& counts) {
  std::vector<Levels> rows;
  Levels l{};
  for (;;) {
    rows.push_back(l);
    int f = k_factors - 1;
    while (f >= 0 && ++l[static_cast<std::size_t>(f)] == counts[static_cast<std::size_t>(f)])
      l[static_cast<std::size_t>(f--)] = 0;
    if (f < 0) return rows;
  }
}

int uncovered_pairs(const Levels& counts, const std::vector<Levels>& rows) {
  std::set<Pair> open = all_pairs(counts);
  for (const Levels& row : rows) for_pairs(row, [&](const Pair& p) { open.erase(p); });
  return static_cast<int>(open.size());
}

std::vector<Levels> pairwise_cover(const Levels& counts) {
  std::set<Pair> open = all_pairs(counts);
  const std::vector<Levels> candidates = full_product(counts);
  std::vector<Levels> rows;
  while (!open.empty()) {
    int best = 0;
    const Levels* chosen = nullptr;
    // Start the search elsewhere each time: the first of equals would repeat the low levels.
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      const Levels& row = candidates[(k + 769 * rows.size()) % candidates.size()];
      int gain = 0;
      for_pairs(row, [&](const Pair& p) { gain += open.count(p) != 0 ? 1 : 0; });
      if (gain > best) {
        best = gain;
        chosen = &row;
      }
    }
    rows.push_back(*chosen);
    for_pairs(*chosen, [&](const Pair& p) { open.erase(p); });
  }
  return rows;
}

bool full_requested() {
  const char* e = std::getenv("TALUS_FULL");
  return e != nullptr && std::string(e) == "1";
}

}  // namespace talus::determinism
