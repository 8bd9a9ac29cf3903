// Whole JSON is accepted, everything else with the place of the fault.
#include "core/io/json_text.hpp"

#include <gtest/gtest.h>

#include <string>

#include "core/io/summary.hpp"

namespace talus {
namespace {

TEST(JsonText, AcceptsJson) {
  for (const char* text :
       {"{}", " [] ", "0", "-1.5e-3", "\"\\u00e4\\n\\\"\"", "[1, {\"a\": [true, false, null]}]\n", "\"\xc3\xa4\""})
    EXPECT_FALSE(json_error(text)) << text;
  EXPECT_FALSE(json_error(summary_json({})));
}

TEST(JsonText, NamesTheFirstFault) {
  EXPECT_EQ(json_error(""), 0u);
  EXPECT_EQ(json_error("{\"a\": 1"), 7u);
  EXPECT_EQ(json_error("{} x"), 3u);
  EXPECT_EQ(json_error("[1,]"), 3u);
  EXPECT_EQ(json_error("01"), 1u);
  EXPECT_EQ(json_error("nul"), 3u);
  EXPECT_EQ(json_error("1."), 2u);
  EXPECT_EQ(json_error("\"a\nb\""), 2u);
  EXPECT_EQ(json_error("\"\xff\""), 1u);
  EXPECT_EQ(json_error("\"\\x\""), 2u);
  EXPECT_EQ(json_error("{1: 2}"), 1u);
  EXPECT_TRUE(json_error(std::string(100000, '[')));
}

TEST(JsonText, EveryBeginningOfASummaryIsTooShort) {
  const std::string whole = summary_json({});
  for (std::size_t n = 0; n + 2 < whole.size(); ++n) EXPECT_TRUE(json_error(whole.substr(0, n))) << n;
}

}  // namespace
}  // namespace talus
