// See text_rows.hpp.
#include "core/io/text_rows.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace talus::text_frames {
namespace {

constexpr std::string_view k_names[] = {"x",  "y",  "z",  "xs",     "ys",       "zs", "vx",   "vy",     "vz",
                                        "wx", "wy", "wz", "radius", "diameter", "id", "type", "species"};
constexpr std::size_t k_most_materials = 256;

/// The entries of `list` in the order `order`.
template <class T>
void arrange(std::vector<T>& list, const std::vector<std::size_t>& order) {
  if (list.empty()) return;
  std::vector<T> sorted;
  sorted.reserve(list.size());
  for (const std::size_t k : order) sorted.push_back(list[k]);
  list = std::move(sorted);
}

}  // namespace

void Rows::fail(const std::string& what, const std::string& cure) const {
  throw Error(ErrorCode::io, what, fmt::format("{}:{}", name_, lines_.number()), cure);
}

bool Rows::has(Field f) const { return std::find(fields_.begin(), fields_.end(), f) != fields_.end(); }

void Rows::columns(std::vector<Field> fields, const std::string& cure) {
  for (std::size_t k = 0; k < fields.size(); ++k)
    if (fields[k] != Field::none && std::count(fields.begin(), fields.end(), fields[k]) > 1)
      fail(fmt::format("column {} is there twice", k_names[static_cast<std::size_t>(fields[k])]), cure);
  if (!fields_.empty() && fields != fields_)
    fail("the columns are others than in the frame before", "one set of columns");
  fields_ = std::move(fields);
  const bool whole = has(Field::x) && has(Field::y) && has(Field::z);
  const bool shares = has(Field::xs) && has(Field::ys) && has(Field::zs);
  if (!whole && !shares) fail("there are no positions", cure);
  if (!has(Field::radius) && !has(Field::diameter))
    fail("there is neither radius nor diameter: points are no spheres", cure);
  for (const auto& three : {std::array{Field::vx, Field::vy, Field::vz}, std::array{Field::wx, Field::wy, Field::wz}}) {
    const auto n = std::count_if(three.begin(), three.end(), [&](Field f) { return has(f); });
    if (n != 0 && n != 3) fail("a velocity lacks components", cure);
  }
  if (!has(Field::vx) && out_.frames.empty())
    out_.notes.push_back(fmt::format("{}: no velocities: the grains are at rest", name_));
}

void Rows::read(Frame& frame, std::int64_t n, const std::optional<Domain>& domain) {
  if (has(Field::xs) && !has(Field::x) && !domain) fail("positions are shares of a box, and there is none");
  std::string_view line;
  for (std::int64_t k = 0; k < n; ++k) {
    if (!lines_.next(line))
      fail(fmt::format("the file ends after {} of {} particles of a frame", k, n), "the whole file");
    particle_text::split_blanks(line, values_);
    if (values_.size() != fields_.size())
      fail(fmt::format("{} values, but there are {} columns", values_.size(), fields_.size()), "one value per column");
    row(frame, domain);
  }
  into_id_order(frame);
}

void Rows::finish() {
  for (const Frame& f : out_.frames)
    if (std::any_of(f.material.begin(), f.material.end(), [](auto m) { return m != 0; })) return;
  for (Frame& f : out_.frames) f.material.clear();
}

void Rows::row(Frame& frame, const std::optional<Domain>& domain) {
  std::array<double, k_fields> value{};
  std::int64_t id = std::ssize(frame.id);
  std::uint8_t material = 0;
  for (std::size_t k = 0; k < fields_.size(); ++k) {
    const auto at = static_cast<std::size_t>(fields_[k]);
    if (fields_[k] == Field::none) continue;
    if (fields_[k] == Field::species) {
      material = material_of(values_[k]);
    } else if (fields_[k] == Field::id) {
      id = number<std::int64_t>(values_[k], "id");
      if (id < 0) fail(fmt::format("id {} is not allowed", id), "ids from 0");
    } else if (fields_[k] == Field::type) {
      const auto type = number<std::int64_t>(values_[k], "type");
      if (type < 1 || type > static_cast<std::int64_t>(k_most_materials))
        fail(fmt::format("type {} is not allowed", type), "types from 1 to 256");
      material = static_cast<std::uint8_t>(type - 1);
    } else {
      value[at] = number<double>(values_[k], k_names[at]);
    }
  }
  const auto three = [&](Field first) {
    const auto k = static_cast<std::size_t>(first);
    return Vec3{value[k], value[k + 1], value[k + 2]};
  };
  Vec3 x = three(Field::x);
  if (!has(Field::x)) {
    const Vec3 share = three(Field::xs);
    for (int k = 0; k < 3; ++k) x[k] = domain->lower[k] + share[k] * (domain->upper[k] - domain->lower[k]);
  }
  const double r = radius_of(value);
  frame.id.push_back(id);
  frame.x.push_back(x);
  frame.v.push_back(three(Field::vx));
  if (has(Field::wx)) frame.w.push_back(three(Field::wx));
  frame.r.push_back(r);
  frame.material.push_back(material);
}

double Rows::radius_of(std::span<const double, k_fields> value) const {
  const double radius = value[static_cast<std::size_t>(Field::radius)];
  const double half = 0.5 * value[static_cast<std::size_t>(Field::diameter)];
  // files of text often have six digits
  constexpr double k_rounding = 1e-4;
  if (has(Field::radius) && has(Field::diameter) && !(std::abs(radius - half) <= k_rounding * std::abs(radius)))
    fail(fmt::format("a radius of {} and a diameter of {} contradict each other", radius, 2 * half),
         "one of the two, or a diameter of two radii");
  const double r = has(Field::radius) ? radius : half;
  if (!(r > 0)) fail(fmt::format("a radius of {} is not allowed", r), "spheres have radii > 0");
  return r;
}

std::uint8_t Rows::material_of(std::string_view species) {
  // "M3" is what Talus writes for a material without a name that is one word.
  std::size_t index = 0;
  const bool numbered = species.size() > 1 && species[0] == 'M' && particle_text::is_number(species.substr(1), index);
  auto& known = out_.species;
  if (!numbered) {
    index = static_cast<std::size_t>(std::find(known.begin(), known.end(), species) - known.begin());
    if (index == known.size())
      index = static_cast<std::size_t>(std::find(known.begin(), known.end(), "") - known.begin());
  }
  if (index >= k_most_materials) fail("more than 256 species", "at most 256 materials");
  if (index >= known.size()) known.resize(index + 1);
  if (!known[index].empty() && known[index] != species)
    fail(fmt::format("species {} and {} are the same material", shown(species), shown(known[index])),
         "names of one kind");
  known[index] = species;
  return static_cast<std::uint8_t>(index);
}

void Rows::into_id_order(Frame& f) const {
  std::vector<std::size_t> order(f.id.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return f.id[a] < f.id[b]; });
  arrange(f.id, order);
  for (std::size_t k = 1; k < f.id.size(); ++k)
    if (f.id[k] == f.id[k - 1])
      fail(fmt::format("id {} is there twice in the frame that ends here", f.id[k]), "ids are unique");
  arrange(f.x, order);
  arrange(f.v, order);
  arrange(f.w, order);
  arrange(f.r, order);
  arrange(f.material, order);
}

}  // namespace talus::text_frames
