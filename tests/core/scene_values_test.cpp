// Claims about single values of scene files: numbers at the limits of their types, texts, and broken texts.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/error.hpp"
#include "core/scene/scene_file.hpp"
#include "core/scene/scene_keys.hpp"

namespace talus {
namespace {

constexpr const char* k_minimal = R"([domain]
lower = [0, 0, 0]
upper = [1, 1, 2]
[time]
step = 1e-5
steps = 100
[[material]]
name = "glass"
density = 2500
[contact]
normal_stiffness = 7e4
)";

Scene parse(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return parse_scene(text, "t.toml", ".", overrides);
}

/// The message of the Error{scene} that parsing must raise.
std::string refusal(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    parse(text, overrides);
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::scene);
    return e.what();
  }
  return "accepted";
}

#define EXPECT_CONTAINS(text, part) EXPECT_NE(std::string(text).find(part), std::string::npos) << text

// Integers that a double cannot hold exactly are values like all others, never garbage.
constexpr const char* k_wide[] = {"9007199254740992",    "9007199254740993",     "-9007199254740993",
                                  "9223372036854775807", "-9223372036854775808", "4611686018427387905"};

TEST(SceneValues, IntegersBeyond2To53AreTheNearestNumber) {
  for (const char* wide : k_wide) {
    const double value = static_cast<double>(std::stoll(wide));
    EXPECT_EQ(parse(k_minimal, {fmt::format("gravity=[0, 0, {}]", wide)}).gravity.z, value);
    if (value > 0) {
      EXPECT_EQ(parse(k_minimal, {fmt::format("time.step={}", wide)}).dt, value);
    }
  }
}

TEST(SceneValues, IntegersBeyond2To53MeetTheRangeOfEveryKeyOfNumbers) {
  int refused = 0;
  for (const SceneKey& key : scene_keys()) {
    const bool number = key.type == KeyType::number || key.type == KeyType::number_or_none ||
                        key.type == KeyType::number_or_auto || key.type == KeyType::integer;
    const bool list = key.type == KeyType::vector || key.type == KeyType::cells || key.type == KeyType::id_range;
    if (!number && !list) continue;
    const std::string text = scene_key_example(key);
    const std::string line = fmt::format("{} = {}\n", key.name, key.example);
    // in its own section: the last header of it, as in scene_key_example
    const std::string header = key.section.empty() ? "" : fmt::format("[{}]", key.section);
    std::size_t at = text.find(line, header.empty() ? 0 : text.rfind(header));
    if (at == std::string::npos) at = text.find(line);
    ASSERT_NE(at, std::string::npos) << full_name(key);
    for (const char* wide : k_wide) {
      const double value = static_cast<double>(std::stoll(wide));
      if (value >= key.low && value <= key.high) continue;
      std::string value_text = wide;
      if (list)
        value_text = key.type == KeyType::id_range ? fmt::format("[0, {}]", wide) : fmt::format("[1, 1, {}]", wide);
      std::string broken = text;
      broken.replace(at, line.size(), fmt::format("{} = {}\n", key.name, value_text));
      EXPECT_CONTAINS(refusal(broken), std::string(key.name) + ": ");
      EXPECT_CONTAINS(refusal(broken), "must be ");
      ++refused;
    }
  }
  EXPECT_GT(refused, 200);
}

TEST(SceneValues, NumbersOfGrainsNearTheEndOfTheIntegersAreRefused) {
  const std::string source = std::string(k_minimal) +
                             "[[source]]\nkind = \"random\"\nregion = { lower = [0, 0, 0], upper = "
                             "[1, 1, 1] }\nsize = { diameter = 0.1 }\n";
  for (const char* n : {"9223372036854775807", "9007199254740993", "1000000000001"})
    EXPECT_CONTAINS(refusal(source + "number = " + n + "\n"),
                    fmt::format("source.0.number: {}: must be an integer", n));
  EXPECT_CONTAINS(refusal(source + "number = 99999999999999999999\n"), "t.toml:16:");
  EXPECT_CONTAINS(refusal(source, {"source.0.number=99999999999999999999"}), "must be an integer");
  EXPECT_CONTAINS(refusal(source + "number = -9223372036854775808\n"), "must be an integer");
}

TEST(SceneValues, DurationsOfAnyNumberOfStepsHaveAnAnswer) {
  EXPECT_CONTAINS(refusal(k_minimal, {"time.duration=1e30"}), "is more than 1e15 steps");
  EXPECT_CONTAINS(refusal(k_minimal, {"time.duration=1", "time.step=1e-300"}), "is more than 1e15 steps");
  EXPECT_CONTAINS(refusal(k_minimal, {"time.step=1e300"}), "must be a number > 0 [s], at most 1e+30");
  EXPECT_EQ(parse(k_minimal, {"time.duration=1", "time.step=1e30"}).steps, 0);
  EXPECT_EQ(parse(k_minimal, {"time.duration=1e-300", "time.step=1e30"}).steps, 0);
}

TEST(SceneTexts, MayHoldAnyUtf8) {
  const std::string umlauts = "Sch\xc3\xbcttgut \xe2\x82\xac \xf0\x9f\x98\x80";
  EXPECT_EQ(parse("title = \"" + umlauts + "\"\n" + k_minimal).title, umlauts);
  EXPECT_EQ(parse("title = '" + umlauts + "'\n" + k_minimal).title, umlauts);
  EXPECT_EQ(parse("title = \"\"\"" + umlauts + "\"\"\"\n" + k_minimal).title, umlauts);
  EXPECT_EQ(parse("title = \"\\u00fc\\U0001F600\"\n" + std::string(k_minimal)).title, "\xc3\xbc\xf0\x9f\x98\x80");
  EXPECT_EQ(parse(k_minimal, {"title=" + umlauts}).title, umlauts) << "bare on the command line";
  EXPECT_EQ(parse(k_minimal, {"title=\"" + umlauts + "\""}).title, umlauts);
  EXPECT_EQ(parse("\xef\xbb\xbf" + std::string(k_minimal)).steps, 100) << "byte order mark";
  std::string named = k_minimal;
  named.replace(named.find("glass"), 5, "Gl\xc3\xa4ser");
  EXPECT_EQ(parse(named).materials[0].name, "Gl\xc3\xa4ser");
  const Scene s =
      parse(named + "[[source]]\nkind = \"file\"\nfile = \"K\xc3\xb6rner.csv\"\nmaterial = \"Gl\xc3\xa4ser\"\n");
  EXPECT_EQ(s.sources[0].file, "K\xc3\xb6rner.csv");
}

TEST(SceneTexts, BytesThatAreNoUtf8AreRefusedWithTheirPlace) {
  EXPECT_CONTAINS(refusal("# a\ntitle = \"gr\xfc\xdf\"\n"),
                  "t.toml:2:12: byte 0xfc is no UTF-8 (save the file as UTF-8)");
  EXPECT_CONTAINS(refusal("title = \"\xc3\xbc\xc3\"\n"), "t.toml:1:11: byte 0xc3 is no UTF-8")
      << "columns are characters";
  EXPECT_CONTAINS(refusal("title = \"\xed\xa0\x80\"\n"), "is no UTF-8") << "a surrogate";
  EXPECT_CONTAINS(refusal("title = \"\\\xc3\x28\"\n"), "is no UTF-8") << "behind a backslash";
  EXPECT_CONTAINS(refusal("titl\xc3\xa9 = 1\n"), "t.toml:1:5: '\xc3\xa9' outside quotes");
  EXPECT_CONTAINS(refusal(std::string("\xff\xfe[\0d\0", 6)), "t.toml: the scene is UTF-16 (save the file as UTF-8)");
  EXPECT_CONTAINS(refusal(k_minimal, {"title=gr\xfc"}), "--set title=gr\\xfc: control characters and bytes");
}

TEST(SceneTexts, QuotesInTheMiddleOfAValueAreRefusedBeforeTheParserSeesThem) {
  // toml++ reads on from a bare value into what follows, and leaves undefined what letters beyond ASCII do there
  EXPECT_CONTAINS(refusal("seed = 1\"\xc3\xbc\"\n"),
                  "t.toml:1:9: quotes behind '1' (a text in quotes stands for itself)");
  EXPECT_CONTAINS(refusal("seed = 1979-05-27 '\xc3\xbc'\n"), "quotes behind '7'");
  EXPECT_CONTAINS(refusal("gravity = [0\"\xc3\xbc\", 0, 0]\n"), "quotes behind '0'");
  EXPECT_CONTAINS(refusal("title = \"a\" \"b\"\n"), "quotes behind '\"'");
  const Scene s = parse("  \"title\" = \"\xc3\xbc\" # \"a\" 'b'\n" + std::string(k_minimal));
  EXPECT_EQ(s.title, "\xc3\xbc");
}

TEST(SceneTexts, ControlCharactersAreRefusedHoweverTheyAreWritten) {
  for (const char* escape : {"\\n", "\\u0000", "\\u001b[31m", "\\u0085", "\\u2028", "\\u202e", "\\t", "\\u007f"}) {
    for (const char* key : {"title", "file", "name"}) {
      std::string text = std::string(k_minimal) + "[[source]]\nkind = \"file\"\n";
      const std::string value = fmt::format("{} = \"x{}y\"\n", key, escape);
      if (std::string(key) == "title")
        text = value + text;
      else
        text += value;
      EXPECT_CONTAINS(refusal(text), fmt::format("{}: ", key)) << text;
      EXPECT_CONTAINS(refusal(text), "must be a text of one line in quotes, without control characters") << text;
    }
  }
  EXPECT_CONTAINS(refusal("title = \"\"\"a\nb\"\"\"\n" + std::string(k_minimal)), "must be a text of one line");
  EXPECT_CONTAINS(refusal("title = \"a\x1b[31m\"\n"), "t.toml:1:11: control character \\x1b");
  EXPECT_CONTAINS(refusal("title = \"a\xe2\x80\xa8\"\n"), "t.toml:1:11: control character");
  EXPECT_CONTAINS(refusal("title = \"" + std::string(5000, 'a') + "\"\n" + k_minimal), "must be a text");
}

// A broken text gives an Error of one line, never another exception or an abort: byte deletions, doublings,
// replacements by letters of the syntax and by bytes and characters beyond ASCII, in the file and in replacements.
TEST(SceneTexts, MutatedTextsOnlyRaiseErrorsOfOneLine) {
  std::string all;
  for (const SceneKey& key : scene_keys()) {
    if (key.name.size() % 3 == 0) all += scene_key_example(key);
  }
  std::uint64_t state = 12345;
  const auto random = [&](std::size_t n) {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<std::size_t>(state >> 33) % n;
  };
  const std::string alphabet = "[]{}=\"'.,#\n\\ \t0123456789eE+-_abtfxinu:TZ";
  const std::string pieces[] = {"\xc3\xbc",
                                "\xe2\x82\xac",
                                "\xf0\x9f\x98\x80",
                                "\xc3",
                                "\xff",
                                "\"\xc3\xbc\"",
                                "'\xc3\xbc'",
                                "\"\"\"",
                                "'''",
                                "\\u00fc",
                                "\\ud800",
                                "\\U0011ffff",
                                "\r\n",
                                "\r",
                                "\xe2\x80\xa8",
                                "9007199254740993",
                                "1979-05-27T07:32:00Z",
                                "0x1p3",
                                "inf",
                                "nan",
                                "1e400",
                                "1_0",
                                "title = \"\xc3\xbc\xc3\x9f\"\n"};
  int refused = 0;
  const auto survives = [&](const std::string& text, const std::vector<std::string>& overrides) {
    try {
      parse(text, overrides);
    } catch (const Error& e) {
      ++refused;
      EXPECT_EQ(e.code(), ErrorCode::scene);
      const std::string_view message = e.what();
      EXPECT_LE(message.size(), 985u);
      for (const char c : message) EXPECT_FALSE(static_cast<unsigned char>(c) < 0x20 || c == 0x7f) << message;
    }
  };
  for (int i = 0; i < 6000; ++i) {
    std::string text = i % 2 == 0 ? std::string(k_minimal) : all.substr(random(all.size()), 400);
    for (std::size_t k = 0, n = 1 + random(4); k < n && !text.empty(); ++k) {
      const std::size_t at = random(text.size());
      switch (random(5)) {
        case 0:
          text.erase(at, 1 + random(5));
          break;
        case 1:
          text.insert(at, text.substr(random(text.size()), random(20)));
          break;
        case 2:
          text.insert(at, pieces[random(std::size(pieces))]);
          break;
        case 3:
          text[at] = static_cast<char>(random(256));
          break;
        default:
          text[at] = alphabet[random(alphabet.size())];
      }
    }
    survives(text, {});
    if (i % 4 == 0) survives(k_minimal, {text.substr(0, 60)});
    if (i % 4 == 1) survives(k_minimal, {"contact.friction=" + text.substr(0, 40)});
  }
  EXPECT_GT(refused, 4000);
}

}  // namespace
}  // namespace talus
