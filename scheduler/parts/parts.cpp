// The one list of optional parts: two lines each. Who calls it: World.
#include "scheduler/part.hpp"
#include "scheduler/team/parallel.hpp"

namespace talus {

// Each returns null where the scene does not want the part.
std::unique_ptr<Part> make_tracer(const Rules& rules);
std::unique_ptr<Part> make_heat(const Rules& rules);
std::unique_ptr<Part> make_conversion(const Rules& rules);
std::unique_ptr<Part> make_gas(const Rules& rules);
std::unique_ptr<Part> make_laser(const Rules& rules);

Parts make_parts(const Rules& rules) {
  Parts parts;
  // laser and gas before heat before conversion: doors.hpp
  for (const auto make : {make_tracer, make_laser, make_gas, make_heat, make_conversion})
    if (auto part = make(rules)) parts.all.push_back(std::move(part));
  return parts;
}

void PartView::blocks(int n, const std::function<void(int)>& fn) const {
  if (team != nullptr && n > 1) return parallel(*team, n, fn);
  for (int k = 0; k < n; ++k) fn(k);
}

}  // namespace talus
