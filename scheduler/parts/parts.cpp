// The one list of optional parts: two lines each. Who calls it: World.
#include "scheduler/part.hpp"

namespace talus {

// Each returns null where the scene does not want the part.
std::unique_ptr<Part> make_tracer(const Rules& rules);
std::unique_ptr<Part> make_gas(const Rules& rules);

Parts make_parts(const Rules& rules) {
  Parts parts;
  for (const auto make : {make_tracer, make_gas})
    if (auto part = make(rules)) parts.all.push_back(std::move(part));
  return parts;
}

}  // namespace talus
