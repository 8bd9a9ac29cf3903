// What the forty-six scenarios of stiff and extreme cases share: the row of the table that perf/stability.py prints,
// and short ways to run a scene into a refusal. Who calls it: tests/stability. Invariant: a scenario that the code does
// not have yet is skipped with its reason, never passed.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "core/base/error.hpp"
#include "tests/physics/physics_support.hpp"

namespace talus::stability {

using namespace talus::physics;

/// The row of a scenario: what is asserted, and the measured figure.
void row(const std::string& asserted, const std::string& figure);
/// What of the scenario does not hold or is not there although the test passes; turns the verdict into "partly".
void shortfall(const std::string& what);
/// Records why a scenario waits; use with GTEST_SKIP().
std::string pending(const std::string& asserted, const std::string& why);

/// Message of the talus::Error that `act` throws, empty if it throws none.
std::string refusal(const std::function<void()>& act);
/// TALUS_FULL=1: the long variants.
bool full();
/// Writes text to a new file of this process and returns its path.
std::string temporary(const std::string& name, const std::string& text);

/// Runs `steps` with the list checked by brute force in every step; returns missed contacts.
std::int64_t audited(const Scene& scene, std::int64_t steps);
/// Energy of relative motion and springs at the last step, all together.
double total_energy(const Energies& e);
std::string sci(double value);        ///< two digits
std::string fmt_ratio(double value);  ///< four digits

}  // namespace talus::stability

#define TALUS_PENDING(asserted, why) GTEST_SKIP() << ::talus::stability::pending(asserted, why)
