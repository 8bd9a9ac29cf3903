// The environment may not reach a trajectory (I4): glibc selects other libm code when FMA and AVX2 are masked off, and
// MXCSR modes change arithmetic. The first must leave every bit alone, the second is refused.
// The test starts itself as a child process, since glibc reads its tunables at program start only.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>
#include <xmmintrin.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "core/base/error.hpp"
#include "core/base/rng.hpp"
#include "tests/determinism/scenes.hpp"
#include "tests/determinism/variants.hpp"

namespace talus::determinism {
namespace {

// glibc 2.36 names features as cpuid does: AVX2_Usable was renamed to AVX2 in 2.33.
constexpr const char* k_masked = "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F";

/// Runs this program's own DISABLED_ test `name` with GLIBC_TUNABLES set or unset; returns the lines it printed after
/// "VALUE ".
std::vector<std::string> child_values(const std::string& name, bool masked) {
  char self[4096];
  const ssize_t length = ::readlink("/proc/self/exe", self, sizeof self - 1);
  if (length <= 0) return {};
  self[length] = 0;
  const std::string command =
      std::string(masked ? std::string("GLIBC_TUNABLES=") + k_masked : "env -u GLIBC_TUNABLES") + " '" + self +
      "' --gtest_also_run_disabled_tests --gtest_filter='" + name + "' 2>&1";
  std::vector<std::string> values;
  std::FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return {};
  char line[512];
  while (std::fgets(line, sizeof line, pipe) != nullptr)
    if (std::string(line).starts_with("VALUE ")) values.emplace_back(line + 6);
  const int status = ::pclose(pipe);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << command;
  return values;
}

TEST(EnvironmentChild, DISABLED_PrintsHashes) {
  for (const NamedScene& named : scenes()) {
    Simulation sim(named.build(), RunOptions{});
    sim.run(600);
    std::printf("VALUE %s %016llx %s\n", named.name, static_cast<unsigned long long>(sim.state_hash()),
                sim.plan().isa.c_str());
  }
}

TEST(EnvironmentChild, DISABLED_PrintsBitsOfLibm) {
  const CounterRng rng(1, 2, 3);
  // a fold of the bits: a sum would round away differences in the last place
  std::uint64_t fold = 0;
  for (std::uint64_t k = 0; k < 200000; ++k) {
    const double x = rng.uniform(k, -20, 20);
    for (const double y : {std::sin(x), std::exp(x / 8), std::pow(x * x + 0.1, 1.3)}) {
      std::uint64_t bits = 0;
      std::memcpy(&bits, &y, sizeof bits);
      fold = mix64(fold + bits);
    }
  }
  std::printf("VALUE %016llx\n", static_cast<unsigned long long>(fold));
}

TEST(Environment, MaskingFmaAndAvx2InGlibcChangesNoBitOfAnyScene) {
  const auto plain = child_values("EnvironmentChild.DISABLED_PrintsHashes", false);
  const auto masked = child_values("EnvironmentChild.DISABLED_PrintsHashes", true);
  ASSERT_EQ(plain.size(), scenes().size());
  EXPECT_EQ(plain, masked);
}

// The mask works: libm itself gives other bits under it. Needs a processor with FMA.
TEST(Environment, TheMaskReachesLibm) {
  if (!__builtin_cpu_supports("fma")) GTEST_SKIP() << "no FMA: glibc has only one code path";
  const auto plain = child_values("EnvironmentChild.DISABLED_PrintsBitsOfLibm", false);
  const auto masked = child_values("EnvironmentChild.DISABLED_PrintsBitsOfLibm", true);
  ASSERT_EQ(plain.size(), 1U);
  ASSERT_EQ(masked.size(), 1U);
  EXPECT_NE(plain, masked);
}

/// Runs a scene on `threads` threads that all inherit `bits` in their MXCSR; returns the refusal's text or "accepted".
std::string run_with_mode(unsigned bits, int threads) {
  std::string result;
  std::thread([&] {
    const Scene scene = sheared_bed();
    RunOptions options;
    options.threads = threads;
    options.chunk = 64;
    Simulation sim(scene, options);
    const unsigned before = _mm_getcsr();
    _mm_setcsr(before | bits);
    try {
      sim.run(20);
      result = "accepted";
    } catch (const Error& e) {
      result = e.what();
    }
    _mm_setcsr(before);
  }).join();
  return result;
}

TEST(Environment, FlushToZeroDenormalsAreZeroAndOtherRoundingAreRefused) {
  EXPECT_EQ(run_with_mode(0, 1), "accepted");
  EXPECT_EQ(run_with_mode(0, 3), "accepted");
  const struct {
    const char* name;
    unsigned bits;
  } modes[] = {{"FTZ", 0x8000},        {"DAZ", 0x0040},      {"FTZ and DAZ", 0x8040},
               {"round down", 0x2000}, {"round up", 0x4000}, {"truncate", 0x6000}};
  for (const auto& mode : modes)
    for (const int threads : {1, 3}) {
      const std::string text = run_with_mode(mode.bits, threads);
      EXPECT_NE(text.find("flush-to-zero"), std::string::npos)
          << mode.name << " on " << threads << " threads: " << text;
      EXPECT_NE(text.find("step 0"), std::string::npos) << text;
    }
}

}  // namespace
}  // namespace talus::determinism
