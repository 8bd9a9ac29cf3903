// Claims about texts of users in messages.
#include "core/base/text.hpp"

#include <gtest/gtest.h>

#include "core/base/error.hpp"

namespace talus {
namespace {

TEST(Text, OnlyWellFormedUtf8HasALength) {
  EXPECT_EQ(utf8_length("a", 0), 1u);
  EXPECT_EQ(utf8_length("\xc3\xbc", 0), 2u);
  EXPECT_EQ(utf8_length("\xe2\x82\xac", 0), 3u);
  EXPECT_EQ(utf8_length("\xf0\x9f\x98\x80", 0), 4u);
  for (const char* bad : {"\x80", "\xc3", "\xc0\xaf", "\xe0\x80\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xff"})
    EXPECT_EQ(utf8_length(bad, 0), 0u);
  EXPECT_EQ(first_invalid_utf8("gr\xc3\xbc\xc3\x9f"), std::string_view::npos);
  EXPECT_EQ(first_invalid_utf8("gr\xfc"), 2u);
}

TEST(Text, ControlCharactersAndInvalidBytesAreEscaped) {
  EXPECT_EQ(shown("a\nb\tc\r\x1b[31m\x7f"), "a\\nb\\tc\\r\\x1b[31m\\x7f");
  EXPECT_EQ(shown(std::string_view("a\0b", 3)), "a\\x00b");
  EXPECT_EQ(shown("gr\xc3\xbc\xc3\x9f \xfc"), "gr\xc3\xbc\xc3\x9f \\xfc");
  EXPECT_EQ(shown("\xc2\x9b|\xe2\x80\xa8|\xe2\x80\xae|\xe2\x81\xa6"),
            "\\xc2\\x9b|\\xe2\\x80\\xa8|\\xe2\\x80\\xae|\\xe2\\x81\\xa6");
  EXPECT_EQ(shown("\xe2\x82\xac"), "\xe2\x82\xac") << "the euro sign is no control";
}

TEST(Text, LongTextsLoseTheirMiddleAndStayWholeCharacters) {
  EXPECT_EQ(shown("0123456789", 10), "0123456789");
  EXPECT_EQ(shown("0123456789abc", 9), "012...abc");
  std::string umlauts;
  for (int i = 0; i < 5000; ++i) umlauts += "\xc3\xbc";
  for (std::size_t most = 8; most < 40; ++most) {
    const std::string s = shown(umlauts, most);
    EXPECT_LE(s.size(), most);
    EXPECT_EQ(first_invalid_utf8(s), std::string_view::npos);
    EXPECT_EQ(shown(s, most), s) << "showing again changes nothing";
  }
  const std::string huge = shown("head" + std::string(1 << 20, '\n') + "tail", 20);
  EXPECT_EQ(huge.substr(0, 4), "head");
  EXPECT_EQ(huge.substr(huge.size() - 4), "tail");
  EXPECT_LE(huge.size(), 20u);
}

TEST(Text, AnEscapedLineIsOneLineAndReadsBackToTheSameBytes) {
  std::string all;
  for (int c = 0; c < 256; ++c) all += static_cast<char>(c);
  for (const std::string& text : {all, std::string("a\\nb\n#: set x=1"), std::string("gr\xc3\xbc\xc3\x9f \\x41"),
                                  std::string("\xe2\x80\xa8"), std::string("end\\"), std::string()}) {
    const std::string line = escaped_line(text);
    EXPECT_EQ(line.find('\n'), std::string::npos);
    EXPECT_EQ(first_invalid_utf8(line), std::string_view::npos);
    EXPECT_EQ(unescaped_line(line), text) << line;
  }
  EXPECT_EQ(escaped_line("plain/folder gr\xc3\xbc\xc3\x9f"), "plain/folder gr\xc3\xbc\xc3\x9f");
}

TEST(Text, MessagesOfErrorsAreOneLineOfAtMostAThousandBytes) {
  const std::string bytes = std::string(100000, '\x01') + "\n";
  const std::string m = Error(ErrorCode::scene, bytes, "folder/" + bytes + "/scene.toml:3:7", bytes).what();
  EXPECT_LE(m.size(), 985u);
  EXPECT_NE(m.find("scene.toml:3:7: "), std::string::npos) << "the end of a place is what counts";
  for (char c : m) EXPECT_GE(static_cast<unsigned char>(c), 0x20);
  EXPECT_STREQ(Error(ErrorCode::io, "what", "where", "cure").what(), "where: what (cure)");
}

}  // namespace
}  // namespace talus
