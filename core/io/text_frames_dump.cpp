// LAMMPS text dumps; see text_frames.hpp.
#include "core/io/text_rows.hpp"

namespace talus {
namespace {

using text_frames::Field;
using text_frames::Rows;
constexpr const char* k_cure = "dump … custom … id type x y z vx vy vz radius [omegax omegay omegaz]";

struct Name {
  std::string_view text;
  Field field;
};
constexpr Name k_names[] = {{"id", Field::id},         {"type", Field::type},
                            {"x", Field::x},           {"y", Field::y},
                            {"z", Field::z},           {"xu", Field::x},
                            {"yu", Field::y},          {"zu", Field::z},
                            {"xs", Field::xs},         {"ys", Field::ys},
                            {"zs", Field::zs},         {"xsu", Field::xs},
                            {"ysu", Field::ys},        {"zsu", Field::zs},
                            {"vx", Field::vx},         {"vy", Field::vy},
                            {"vz", Field::vz},         {"omegax", Field::wx},
                            {"omegay", Field::wy},     {"omegaz", Field::wz},
                            {"radius", Field::radius}, {"diameter", Field::diameter}};

class DumpReader {
 public:
  DumpReader(std::string_view text, const std::string& name) : lines_(text), name_(name), rows_(lines_, name, out_) {}

  TextFrames read() {
    std::string_view line;
    while (lines_.next(line))
      if (!line.empty()) item(line);
    if (open_) rows_.fail("the last frame is cut off", "the whole file");
    if (out_.frames.empty()) rows_.fail("there is no frame", k_cure);
    rows_.finish();
    if (!timed_ && out_.frames.size() > 1)
      out_.notes.push_back(name_ + ": no times: the numbers of the steps stand for them");
    return std::move(out_);
  }

 private:
  void item(std::string_view line) {
    constexpr std::string_view start = "ITEM:";
    if (!line.starts_with(start)) rows_.fail(fmt::format("'{}' is no ITEM", shown(line, 60)), "a LAMMPS text dump");
    line = particle_text::trim(line.substr(start.size()));
    if (line == "TIMESTEP") {
      begin();
      frame_.step = rows_.number<std::int64_t>(next(), "TIMESTEP");
    } else if (line == "TIME") {
      begin();
      frame_.time = rows_.number<double>(next(), "TIME");
      timed_ = time_ = true;
    } else if (line == "UNITS") {
      next();
    } else if (line == "NUMBER OF ATOMS") {
      n_ = rows_.number<std::int64_t>(next(), "NUMBER OF ATOMS");
      if (n_ < 0) rows_.fail(fmt::format("{} atoms", n_), "");
    } else if (line.starts_with("BOX BOUNDS")) {
      box(line.substr(10));
    } else if (line.starts_with("ATOMS")) {
      atoms(line.substr(5));
    } else {
      rows_.fail(fmt::format("ITEM: {} is not known", shown(line, 60)), "a LAMMPS text dump of atoms");
    }
  }

  /// TIME and TIMESTEP stand in either order before the rest of a frame.
  void begin() {
    if (open_) return;
    open_ = true;
    time_ = false;
    n_ = -1;
    domain_.reset();
    frame_ = {};
  }

  std::string_view next() {
    std::string_view line;
    if (!lines_.next(line)) rows_.fail("the last frame is cut off", "the whole file");
    return line;
  }

  void box(std::string_view kinds) {
    std::vector<std::string_view> words, values;
    particle_text::split_blanks(kinds, words);
    const bool general = !words.empty() && (words[0] == "abc" || words[0] == "xy");
    Domain d;
    for (auto& axis : d.boundary) axis = {Boundary::open, Boundary::open};
    for (int k = 0; k < 3; ++k) {
      particle_text::split_blanks(next(), values);
      if (values.size() != 2 && values.size() != 3) rows_.fail("a box bound is 'lower upper'", k_cure);
      d.lower[k] = rows_.number<double>(values[0], "box bound");
      d.upper[k] = rows_.number<double>(values[1], "box bound");
      if ((values.size() == 3 && rows_.number<double>(values[2], "tilt") != 0) || (general && words[0] == "abc"))
        rows_.fail("the box is skewed", "a box with right angles");
      const auto word = static_cast<std::size_t>(k) + (general ? 3 : 0);
      if (word < words.size() && words[word] == "pp")
        d.boundary[static_cast<std::size_t>(k)] = {Boundary::periodic, Boundary::periodic};
    }
    domain_ = d;
  }

  void atoms(std::string_view names) {
    if (!open_ || n_ < 0) rows_.fail("ATOMS before TIMESTEP and NUMBER OF ATOMS", "a LAMMPS text dump");
    std::vector<std::string_view> words;
    particle_text::split_blanks(names, words);
    std::vector<Field> fields;
    std::string ignored;
    for (const std::string_view w : words) {
      fields.push_back(Field::none);
      for (const Name& n : k_names)
        if (n.text == w) fields.back() = n.field;
      if (fields.back() == Field::none) ignored += (ignored.empty() ? "" : ", ") + shown(w, 40);
    }
    if (!ignored.empty() && out_.frames.empty())
      out_.notes.push_back(fmt::format("{}: ignored: {}", name_, shown(ignored, 200)));
    rows_.columns(std::move(fields), k_cure);
    rows_.read(frame_, n_, domain_);
    if (!time_) frame_.time = static_cast<double>(frame_.step);
    if (!out_.frames.empty() && frame_.step <= out_.frames.back().step)
      rows_.fail(fmt::format("step {} comes after step {}", frame_.step, out_.frames.back().step),
                 "frames in ascending order");
    out_.frames.push_back(std::move(frame_));
    out_.domains.push_back(domain_);
    open_ = false;
  }

  particle_text::Lines lines_;
  const std::string& name_;
  TextFrames out_;
  Rows rows_;
  Frame frame_;
  std::optional<Domain> domain_;
  std::int64_t n_ = -1;
  bool open_ = false, time_ = false, timed_ = false;
};

}  // namespace

TextFrames parse_lammps_dump(std::string_view text, const std::string& name) { return DumpReader(text, name).read(); }

}  // namespace talus
