// summary.json, read back by Python's json.
#include "core/io/summary.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/io/output_frames.hpp"

namespace talus {
namespace {

using test::TemporaryFolder;

bool json_says(const std::string& path, const std::string& expression) {
  const std::string command =
      "/usr/bin/python3 -c 'import json,sys; d = json.load(open(sys.argv[1], encoding=\"utf-8\"));"
      " sys.exit(0 if (" +
      expression + ") else 1)' " + path;
  return std::system(command.c_str()) == 0;
}

Summary example() {
  Summary s;
  s.title = "hopper \"A\" \\ tab\t line\n \x01 \xc3\xa9 bad\xff";
  s.particles = 125000;
  s.steps = 1000000;
  s.wall_s = 0.1;
  s.nodes = {{"narrow_phase", 5, 1.25}, {"in\"tegrate", 5, std::numeric_limits<double>::infinity()}};
  s.mean_interval = std::nan("");
  s.rebuild_steps = {3, 50, 99};
  s.seed = std::numeric_limits<std::uint64_t>::max();
  s.kinetic_energy = 1.0 / 3;
  s.state_hash = 0xab;
  return s;
}

TEST(Summary, IsValidJsonWithExactValues) {
  TemporaryFolder folder;
  const std::string path = folder / "summary.json";
  write_summary(path, example());
  EXPECT_TRUE(json_says(path, "d[\"title\"] == \"hopper \\\"A\\\" \\\\ tab\\t line\\n \\x01 \\u00e9 bad\\ufffd\""));
  EXPECT_TRUE(json_says(path, "d[\"particles\"] == 125000 and d[\"wall_s\"] == 0.1"));
  EXPECT_TRUE(json_says(path, "d[\"kinetic_energy\"] == 1 / 3 and d[\"seed\"] == 2 ** 64 - 1"));
  EXPECT_TRUE(json_says(path, "d[\"state_hash\"] == \"00000000000000ab\""));
  EXPECT_TRUE(json_says(path, "d[\"rebuild_steps\"] == [3, 50, 99]"));
  EXPECT_TRUE(json_says(path, "d[\"nodes\"][0] == {\"name\": \"narrow_phase\", \"calls\": 5, \"seconds\": 1.25}"));
  EXPECT_FALSE(json_says(path, "d[\"particles\"] == 1"));  // the check itself can fail
}

TEST(Summary, NonFiniteAndAbsentValuesAreNull) {
  TemporaryFolder folder;
  const std::string path = folder / "summary.json";
  write_summary(path, example());
  EXPECT_TRUE(json_says(path, "d[\"mean_interval\"] is None and d[\"nodes\"][1][\"seconds\"] is None"));
  EXPECT_TRUE(json_says(path, "d[\"elastic_energy\"] is None and d[\"missed_contacts\"] is None"));
}

TEST(Summary, HasTheDocumentedFields) {
  TemporaryFolder folder;
  write_summary(folder / "s", Summary{});
  for (const char* key : {"particles",
                          "steps",
                          "wall_s",
                          "particle_steps_per_s",
                          "nodes",
                          "rebuilds",
                          "shortest_interval",
                          "mean_interval",
                          "candidate_pairs",
                          "contacts",
                          "late_detections",
                          "missed_contacts",
                          "bytes_per_particle",
                          "peak_rss_bytes",
                          "verlet_k",
                          "verlet_k_automatic",
                          "list_series",
                          "policy_guarantee",
                          "policy",
                          "threads",
                          "isa",
                          "seed",
                          "version",
                          "kinetic_energy",
                          "kinetic_rotation",
                          "potential_energy",
                          "elastic_energy",
                          "dissipated_energy",
                          "state_hash"})
    EXPECT_NE(test::slurp(folder / "s").find(std::string("\"") + key + "\": "), std::string::npos) << key;
}

TEST(Summary, CountsSolvedPairsOfSuperquadricsAlone) {
  Summary s;
  EXPECT_EQ(summary_json(s).find("safe_pairs"), std::string::npos);
  s.solved_pairs = 7;
  s.safe_pairs = 0;
  EXPECT_NE(summary_json(s).find("\"solved_pairs\": 7"), std::string::npos);
  EXPECT_NE(summary_json(s).find("\"safe_pairs\": 0"), std::string::npos);
}

TEST(Summary, InvalidUtf8IsReplacedNotCopied) {
  EXPECT_EQ(json_string("\xed\xa0\x80"), "\"\\ufffd\\ufffd\\ufffd\"");                         // surrogate
  EXPECT_EQ(json_string("\xc0\xaf"), "\"\\ufffd\\ufffd\"");                                    // overlong
  EXPECT_EQ(json_string("\xf0\x9f\x98\x80 \xe2\x82"), "\"\xf0\x9f\x98\x80 \\ufffd\\ufffd\"");  // cut short
}

TEST(Summary, PeakMemoryIsThatOfTheProcess) {
  std::vector<char> block(64 << 20, 1);
  ASSERT_EQ(block[12345], 1);
  EXPECT_GE(peak_rss_bytes(), std::int64_t{64} << 20);
}

}  // namespace
}  // namespace talus
