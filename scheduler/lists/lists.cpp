// See lists.hpp.
#include "scheduler/lists/lists.hpp"

#include <string>

namespace talus {

Lists::Lists(const Rules& rules, const SkinRule& rule, Columns& columns) : skin(rule) {
  tuner.prepare(rules, skin);
  const auto row = [](const char* name, const std::string& why, bool in, double last) {
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
  const Policy& policy = *skin.policy;
  const std::string of_policy = "list.policy " + policy.name();
  columns.add(row("outer", policy.cuts ? of_policy : "no outer list", policy.cuts, 0), outer);
  columns.add(row("near", policy.cuts ? of_policy : "no outer list", policy.cuts, 0), near);
  ColumnInfo d = row("drift", policy.row_drift ? of_policy : "displacements count from x0 itself", policy.row_drift, 0);
  d.unit = "m/s";
  d.dead = {0};
  columns.add(d, drift);
  ColumnInfo s;
  s.name = "next_skin";
  s.label = "next skin";
  s.unit = "m";
  s.why = policy.past ? of_policy : "the skins need no past";
  s.in = policy.past;
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
