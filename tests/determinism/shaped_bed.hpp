// A bed of eggs, rods and balls that fall on each other, for parts that know bodies: conversion, gas.
#pragma once

#include <fmt/format.h>

#include <string>

#include "tests/determinism/scenes.hpp"

namespace talus::determinism {

inline std::string grain_file(const std::string& text) {
  static int number = 0;
  return temporary_file(fmt::format("shaped-grain-{}.toml", number++), text);
}

inline std::string source_of(const char* name, const char* kind, const char* more, const char* region) {
  return fmt::format("[[source]]\nname = \"{}\"\nkind = \"{}\"\n{}\n[source.region]\n{}\n", name, kind, more, region);
}

inline constexpr const char* k_bed = "lower = [-0.01, 0, 0.001]\nupper = [0.01, 0.016, 0.021]";
inline constexpr const char* k_shapes =
    "[[shape]]\nname = \"egg\"\nkind = \"superquadric\"\nsemi_axes = [0.002, 0.001, 0.0014]\nexponents = [3, 2.5]\n"
    "[[shape]]\nname = \"rod\"\nspheres = [0, 0, -0.0015, 0.001, 0, 0, 0, 0.001, 0, 0, 0.0015, 0.001]\n";

/// Eggs, rods and balls that fall on each other. `parts`: sections of heat and conversion; `matter`: keys of the
/// material; `law`: keys of the contacts.
inline std::string bed_text(const std::string& parts, const std::string& matter, const std::string& law,
                            double dt = 8e-6) {
  return fmt::format(R"(title = "shapes with shells"
gravity = [1, 0, -9.81]
seed = 11
sort_every = 250
[domain]
lower = [-0.01, 0, 0]
upper = [0.01, 0.016, 0.03]
boundary = ["periodic", ["wall", "open"], "wall"]
[time]
step = {}
duration = 1
[checks]
max_overlap = 0.5
[[material]]
name = "m"
density = 700
young = 5e5
poisson = 0.3
{}
[contact]
{}
)",
                     dt, matter, law) +
         parts + source_of("eggs", "random", "number = 80\nshape = \"egg\"\nvelocity = [0, 0.3, -1]", k_bed) +
         "[source.size]\nkind = \"uniform\"\nmin = 0.0018\nmax = 0.0026\n" +
         source_of("rods", "stream",
                   "shape = \"rod\"\nnumber_rate = 12000\ninterval = 0.0007\nvelocity = [0.2, 0.2, -1]",
                   "lower = [-0.01, 0, 0.022]\nupper = [0.01, 0.016, 0.0295]") +
         source_of("still", "random", "number = 10\nshape = \"rod\"\nvelocity_jitter = 0.4", k_bed) +
         source_of("balls", "random", "number = 40\nvelocity_jitter = 0.4", k_bed) +
         "[source.size]\nkind = \"uniform\"\nmin = 0.0014\nmax = 0.002\n" + k_shapes;
}

inline constexpr const char* k_law = "model = \"hertz_mindlin\"\nrestitution = 0.6\nfriction = 0.4";

}  // namespace talus::determinism
