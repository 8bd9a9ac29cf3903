// See particle_header.hpp.
#include "core/tables/particle_header.hpp"

#include <array>
#include <optional>

#include "core/base/suggest.hpp"

namespace talus::particle_text {

using Column = ParticleColumn;

bool Splitter::split_quoted(std::string_view line) {
  const bool blanks = separator_ == ' ';
  const auto separates = [&](char c) { return blanks ? is_space(c) : c == separator_; };
  std::size_t i = 0;
  const auto skip_blanks = [&] {
    while (i < line.size() && is_space(line[i]) && (blanks || line[i] != separator_)) ++i;
  };
  while (true) {  // every turn takes a character or ends
    skip_blanks();
    if (blanks && i == line.size()) return true;
    if (i < line.size() && line[i] == '"') {
      std::string& text = unquoted_.emplace_back();
      for (++i;; ++i) {
        if (i == line.size()) return false;
        if (line[i] == '"') {
          if (i + 1 == line.size() || line[i + 1] != '"') break;
          ++i;  // a doubled quote is one
        }
        text += line[i];
      }
      ++i;
      fields_.push_back(trim(text));
    } else {
      const std::size_t begin = i;
      while (i < line.size() && !separates(line[i])) ++i;
      fields_.push_back(trim(line.substr(begin, i - begin)));
    }
    if (blanks) continue;
    skip_blanks();
    if (i == line.size()) return true;
    if (line[i] != separator_) return false;  // text behind a closing quote
    ++i;
  }
}

bool is_comment(std::string_view line) {
  return line.starts_with('#') || line.starts_with('%') || line.starts_with("//");
}

namespace {

constexpr const char* k_allowed =
    "columns: x, y, z, radius (or diameter); optional vx, vy, vz, wx, wy, wz, material, fixed; of bodies shape, scale, "
    "qw, qx, qy, qz";
constexpr int k_header_search = 60;  // lines: other programs write a preamble

/// The separator of a line: blanks where it has no other.
char separator_of(std::string_view line) {
  std::array<int, 4> count{};
  constexpr std::string_view candidates = ";,\t|";
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    const std::size_t k = candidates.find(c);
    if (!quoted && k != std::string_view::npos) ++count[k];
  }
  if (count[0] > 0) return ';';  // commas beside it are decimal commas
  const auto most = std::max_element(count.begin(), count.end());
  return *most > 0 ? candidates[static_cast<std::size_t>(most - count.begin())] : ' ';
}

/// Meaning of each field; of several with the same one Talus's own name counts. Returns the second of two names that
/// cannot be told apart, or nothing.
std::optional<std::string> assign(Header& h) {
  std::optional<std::string> twice;
  std::vector<bool> own;
  std::array<int, k_particle_columns> holder;
  holder.fill(-1);
  for (std::size_t k = 0; k < h.names.size(); ++k) {
    const ColumnMeaning m = column_meaning(h.names[k]);
    h.meaning.push_back(m.column);
    h.unit.push_back(m.unit);
    own.push_back(m.own);
    if (m.column == Column::none) continue;
    int& first = holder[static_cast<std::size_t>(m.column)];
    if (first < 0) {
      first = static_cast<int>(k);
    } else if (own[k] != own[static_cast<std::size_t>(first)]) {
      const std::size_t loser = own[k] ? static_cast<std::size_t>(first) : k;
      h.meaning[loser] = Column::none;
      if (own[k]) first = static_cast<int>(k);
    } else if (!twice) {
      twice = h.names[k];
    }
  }
  return twice;
}

class HeaderReader {
 public:
  HeaderReader(Lines& lines, const std::string& name, std::vector<std::string>& notes, bool bodies)
      : lines_(lines), name_(name), notes_(notes), bodies_(bodies) {}

  Header read() {
    std::string_view line;
    Header best;
    std::string comment;
    std::int64_t comment_row = 0, before = 0;
    char forced = 0;
    for (int k = 0; k < k_header_search && lines_.next(line); ++k) {
      if (line.empty()) continue;
      if (is_comment(line)) {
        comment = line;
        comment_row = lines_.number();
        continue;
      }
      if (line.size() == 5 && line.starts_with("sep=")) {  // written by and for spreadsheets
        forced = line[4];
        continue;
      }
      if (is_data(line)) {
        if (best.row == 0) return from_comment(comment, comment_row, line);
        break;
      }
      Header h = candidate(separator_of(line) == '\t' ? lines_.raw() : line, lines_.number(), forced);
      if (h.complete()) {
        if (before > 0)
          notes_.push_back(fmt::format("{}: what stands before the header row {} is ignored", name_, h.row));
        return checked(std::move(h));
      }
      ++before;
      if (known(h) > known(best) || best.row == 0) best = std::move(h);
    }
    if (best.row == 0) fail(name_, lines_.number(), "no particles", "a header row, then one row per particle");
    return checked(std::move(best));
  }

 private:
  static std::ptrdiff_t known(const Header& h) {
    return std::count_if(h.meaning.begin(), h.meaning.end(), [](Column c) { return c != Column::none; });
  }

  /// A row of numbers only.
  static bool is_data(std::string_view line) {
    Splitter s(separator_of(line));
    if (!s.split(line)) return false;
    bool any = false;
    for (std::string_view f : s.fields()) {
      double value = 0;
      if (f.empty()) continue;
      std::string point(f);
      std::replace(point.begin(), point.end(), ',', '.');
      if (!is_number(std::string_view(point), value)) return false;
      any = true;
    }
    return any;
  }

  Header candidate(std::string_view line, std::int64_t row, char forced) const {
    Header h;
    h.row = row;
    h.separator = forced != 0 ? forced : separator_of(line);
    Splitter s(h.separator);
    if (!s.split(line)) fail(name_, row, "a quote is not closed", k_allowed);
    for (std::string_view f : s.fields()) {
      if (f.size() >= 2 && f.front() == '\'' && f.back() == '\'') f = f.substr(1, f.size() - 2);
      h.names.emplace_back(f);
    }
    if (const auto twice = assign(h); twice && h.complete())
      fail(name_, row, fmt::format("column '{}' is named twice, or another name means the same", shown(*twice)),
           k_allowed);
    return h;
  }

  /// "# x y z radius" above the numbers, or "#format x_y_z_r" (Yade).
  Header from_comment(const std::string& comment, std::int64_t row, std::string_view first) {
    std::string text(
        trim(std::string_view(comment).substr(std::min(comment.find_first_not_of("#%/ \t"), comment.size()))));
    if (text.starts_with("format ")) {
      text = text.substr(7);
      std::replace(text.begin(), text.end(), '_', ' ');
    }
    Header h;
    if (!text.empty()) h = candidate(text, row, 0);
    Splitter data(separator_of(first));
    data.split(first);
    if (!h.complete() || h.names.size() != data.fields().size())
      fail(name_, lines_.number(),
           "a row of numbers, but no header row before it (`talus convert` makes a CSV file of .xyz)", k_allowed);
    h.separator = data.separator();
    notes_.push_back(fmt::format("{}: the columns are named by the comment in line {}", name_, row));
    h.first_row_read = true;
    return checked(std::move(h));
  }

  Header checked(Header h) const {
    const auto require = [&](Column c) {
      if (h.has(c)) return;
      std::vector<std::string> others;
      for (std::size_t k = 0; k < h.names.size() && k < 100; ++k)
        if (h.meaning[k] == Column::none) others.push_back(h.names[k]);
      const std::string best = nearest_name(column_name(c), others);
      fail(name_, h.row,
           fmt::format("column '{}' is missing{}", column_name(c),
                       best.empty() ? "" : fmt::format(" (is it '{}'?)", shown(best))),
           k_allowed);
    };
    for (Column c : {Column::x, Column::y, Column::z}) require(c);
    const bool bodies = bodies_ || h.has(Column::shape);
    if (!h.has(Column::diameter) && !(bodies && h.has(Column::scale))) require(Column::radius);
    if (h.has(Column::body) && !bodies)
      fail(name_, h.row, "column 'body' says that its rows are spheres of rigid bodies, which a table cannot hold",
           "`talus convert` makes a table of a run with a row for each body");
    const auto together = [&](Column a, Column b, Column c) {
      if (h.has(a) != h.has(b) || h.has(b) != h.has(c))
        fail(name_, h.row,
             fmt::format("{}, {} and {} come together or not at all", column_name(a), column_name(b), column_name(c)),
             k_allowed);
    };
    together(Column::vx, Column::vy, Column::vz);
    together(Column::wx, Column::wy, Column::wz);
    together(Column::qw, Column::qx, Column::qy);
    together(Column::qx, Column::qy, Column::qz);
    check_units(h);
    return h;
  }

  /// Stated units must belong together; they are not converted.
  void check_units(const Header& h) const {
    std::string length;
    const auto refuse = [&](std::size_t k, const std::string& cure) {
      fail(name_, h.row, fmt::format("column '{}' is in '{}'", shown(h.names[k]), shown(h.unit[k])), cure);
    };
    for (std::size_t k = 0; k < h.names.size(); ++k) {
      const Column c = h.meaning[k];
      if (h.unit[k].empty() || !(c <= Column::radius || c == Column::diameter)) continue;
      const bool metres = h.unit[k] == "m" || h.unit[k].starts_with("meter") || h.unit[k].starts_with("metre");
      const std::string unit = metres ? "m" : h.unit[k];
      if (!length.empty() && unit != length)
        refuse(k, fmt::format("all lengths in one unit; others are in '{}'", shown(length)));
      length = unit;
    }
    for (std::size_t k = 0; k < h.names.size(); ++k) {
      const Column c = h.meaning[k];
      const std::string& unit = h.unit[k];
      if (c >= Column::wx && c <= Column::wz &&
          (unit.find("deg") != std::string::npos || unit == "rpm" || unit.starts_with("rev")))
        refuse(k, "angular velocities in rad/s");
      constexpr std::string_view lengths[] = {"mm/", "cm/", "um/", "km/", "in/", "ft/"};
      const bool scaled =
          std::any_of(std::begin(lengths), std::end(lengths), [&](auto l) { return unit.starts_with(l); });
      if (c >= Column::vx && c <= Column::vz && scaled && !unit.starts_with(length + "/"))
        refuse(k, "velocities in the unit of length per second");
    }
    if (!length.empty() && length != "m")
      notes_.push_back(fmt::format("{}: lengths are in '{}' and are not converted", name_, shown(length)));
  }

  Lines& lines_;
  const std::string& name_;
  std::vector<std::string>& notes_;
  bool bodies_;
};

}  // namespace

Header read_header(Lines& lines, const std::string& name, std::vector<std::string>& notes, bool bodies) {
  return HeaderReader(lines, name, notes, bodies).read();
}

}  // namespace talus::particle_text
