// See contact_records.hpp.
#include "scheduler/state/contact_records.hpp"

#include <algorithm>
#include <utility>

#include "core/base/error.hpp"

namespace talus {

namespace {

/// A wall contact as checkpoints hold it, beside its history of rolling and twisting.
struct WallRecord {
  Row row;
  std::int32_t unused;  ///< no padding: the bytes are a function of the state
  std::int32_t wall, element;
  Vec3 normal;
  double distance;
  Vec3 velocity;
  double h[k_usual_history];  ///< the rest is in wall_history
};

}  // namespace

/// Contacts without the columns that the scene does not have: pairs of rows, then the columns of each contact.
void write_contacts(const Rules& rules, const Contacts& contacts, const WallSet& walls, bool failed,
                    CheckpointWriter& out) {
  std::size_t most = 0;
  for (const auto& c : contacts.chunks) most += static_cast<std::size_t>(c->contacts.end[2]);
  std::vector<std::uint8_t> rows, history;
  rows.reserve(most * 2 * sizeof(Row));
  history.reserve(most * static_cast<std::size_t>(rules.has.history_columns) * sizeof(double));
  const auto append = [](std::vector<std::uint8_t>& to, const void* data, std::size_t bytes) {
    const auto* from = static_cast<const std::uint8_t*>(data);
    to.insert(to.end(), from, from + bytes);
  };
  for (const auto& c : contacts.chunks)
    for (const ContactEntry& e : contacts_of(rules, *c, failed)) {
      append(rows, &e.a, sizeof e.a);
      append(rows, &e.b, sizeof e.b);
      append(history, e.h, static_cast<std::size_t>(rules.has.history_columns) * sizeof(double));
    }
  out.add("contacts", std::move(rows));
  out.add("contact_history", std::move(history));
  const auto entries = collect_wall_states(rules, contacts);
  std::vector<WallRecord> records(entries.size());
  std::vector<Vec3> centres;
  std::vector<double> moments, more;
  for (std::size_t k = 0; k < entries.size(); ++k) {
    const WallContact& t = entries[k].contact;
    records[k] = {entries[k].row, 0, t.wall, t.element, t.normal, t.distance, t.velocity, {}};
    std::copy_n(entries[k].h, k_usual_history, records[k].h);
    for (int q = k_usual_history; q < rules.has.law_columns; ++q) more.push_back(entries[k].h[q]);
    centres.push_back(t.centre);
    moments.insert(moments.end(), entries[k].m, entries[k].m + rules.has.moment_columns);
  }
  out.add_array("wall_contacts", records.data(), records.size());
  if (walls.has_images()) out.add_array("wall_centres", centres.data(), centres.size());
  if (rules.has.moments) out.add_array("wall_moments", moments.data(), moments.size());
  if (rules.has.law_columns > k_usual_history) out.add_array("wall_history", more.data(), more.size());
}

std::vector<ContactEntry> read_contacts(const Rules& rules, const CheckpointReader& in) {
  std::vector<Row> rows;
  std::vector<double> history;
  in.read_array<Row>("contacts", rows);
  in.read_array<double>("contact_history", history);
  const auto columns = static_cast<std::size_t>(rules.has.history_columns);
  if (rows.size() % 2 != 0 || history.size() != rows.size() / 2 * columns)
    throw Error(ErrorCode::io, "contacts and their history do not fit together", in.path());
  std::vector<ContactEntry> out(rows.size() / 2);
  for (std::size_t k = 0; k < out.size(); ++k) {
    out[k].a = rows[2 * k];
    out[k].b = rows[2 * k + 1];
    std::copy_n(history.begin() + static_cast<std::ptrdiff_t>(k * columns), columns, out[k].h);
  }
  return out;
}

/// `numbers`: what each wall of the checkpoint is now, -1: gone; empty: the same walls.
std::vector<WallEntry> read_walls(const Rules& rules, const WallSet& walls, const CheckpointReader& in,
                                  const std::vector<int>& numbers) {
  std::vector<WallRecord> records;
  std::vector<Vec3> centres;
  std::vector<double> moments, more;
  in.read_array<WallRecord>("wall_contacts", records);
  // Walls that are new at a resume may be the first with images; a grain in touch then has no former image to keep.
  const bool images = walls.has_images() && in.has("wall_centres");
  if (images) in.read_array<Vec3>("wall_centres", centres);
  if (rules.has.moments) in.read_array<double>("wall_moments", moments);
  const auto columns = static_cast<std::size_t>(rules.has.moment_columns);
  const auto beyond = static_cast<std::size_t>(std::max(rules.has.law_columns - k_usual_history, 0));
  if (beyond > 0) in.read_array<double>("wall_history", more);
  if (moments.size() != records.size() * columns || more.size() != records.size() * beyond ||
      (images && centres.size() != records.size()))
    throw Error(ErrorCode::io, "wall contacts and their history do not fit together", in.path());
  std::vector<WallEntry> out;
  for (std::size_t k = 0; k < records.size(); ++k) {
    const WallRecord& r = records[k];
    WallEntry e;
    e.row = r.row;
    e.contact = {r.wall, r.element, r.normal, r.distance, r.velocity, centres.empty() ? Vec3{} : centres[k]};
    std::copy_n(r.h, k_usual_history, e.h);
    std::copy_n(more.begin() + static_cast<std::ptrdiff_t>(k * beyond), beyond, e.h + k_usual_history);
    std::copy_n(moments.begin() + static_cast<std::ptrdiff_t>(k * columns), columns, e.m);
    if (!numbers.empty()) {
      const auto before = static_cast<std::size_t>(r.wall);
      e.contact.wall = before < numbers.size() ? numbers[before] : -1;
      e.contact.element = -1;  // elements are numbered through all walls: the history passes on by the normal
    }
    if (numbers.empty() || e.contact.wall >= 0) out.push_back(e);
  }
  return out;
}

}  // namespace talus
