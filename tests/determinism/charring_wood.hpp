// Grain file of the conversion tests: wood that has begun to char, so that all happens within a short run. The tests
// add further char reactions and the surroundings.
#pragma once

#include <string>

namespace talus::determinism {

inline const std::string k_charring_wood = R"(title = "wood, water and char"
[time]
step = 0.001
duration = 1
[grain]
diameter = 0.002
temperature = 300
[material]
density = 700
moisture = 0.1
ash = 0.02
initial = { wood = 0.5, char = 0.38 }
[heat_capacity]
fuel = { polynomial = [1112, 4.85], origin = 273.15, range = [273, 900] }
char = 1300
ash = 900
[conductivity]
fuel = 0.15
wet = 0.25
char = 0.1
ash = 0.2
[[solid]]
name = "wood"
[[solid]]
name = "char"
kind = "char"
[[gas]]
name = "volatiles"
[[reaction]]
reactant = "wood"
products = { char = 0.2, volatiles = 0.8 }
A = 1e10
E = 1.25e5
heat = 1e5
[shrinkage]
drying = 0.1
devolatilisation = 0.3
burn_off = 0.9
[[char_reaction]]
oxidant = "O2"
A = 17.15
n = 1
E = 74830
)";

}  // namespace talus::determinism
