// See lists.hpp.
#include "scheduler/lists/lists.hpp"

namespace talus {

Lists::Lists(const Rules& rules, const SkinRule& rule, Columns& columns) : skin(rule) {
  tuner.prepare(rules, skin);
  const auto row = [](const char* name, const char* why, bool in, double last) {
    ColumnInfo i;
    i.name = name;
    i.unit = "m";
    i.why = why;
    i.in = in;
    i.width = 4;
    i.dead = {k_gone, k_gone, k_gone, last};
    i.moves = false;
    return i;
  };
  columns.add(row("x0", "reference position and skin of the list", true, 1e300), x0);
  const bool cuts = skin.cuts();
  columns.add(row("outer", cuts ? "list.policy outer_inner" : "no outer list", cuts, 0), outer);
  columns.add(row("near", cuts ? "list.policy outer_inner" : "no outer list", cuts, 0), near);
  const bool profile = skin.policy == ListPolicy::velocity_profile;
  ColumnInfo d =
      row("drift", profile ? "list.policy velocity_profile" : "displacements count from x0 itself", profile, 0);
  d.unit = "m/s";
  d.dead = {0};
  columns.add(d, drift);
  const bool past = skin.policy == ListPolicy::displacement_history;
  ColumnInfo s;
  s.name = "next_skin";
  s.label = "next skin";
  s.unit = "m";
  s.why = past ? "list.policy displacement_history" : "the skins need no past";
  s.in = past;
  s.dead = {-1};
  columns.add(s, next_skin);
}

void mark_gone(Rows& rows, Lists& lists, Row i) {
  for (auto* p : {&rows.p, &lists.x0})
    for (int k = 0; k < 3; ++k) (*p)[4L * i + k] = k_gone;
  rows.p[4L * i + 3] = 0;
  lists.x0[4L * i + 3] = 1e300;
  double* v = rows.v.data() + static_cast<long>(rows.stride) * i;
  for (int k = 0; k < rows.stride; ++k) v[k] = 0;
}

}  // namespace talus
