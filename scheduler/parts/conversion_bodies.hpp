// Bodies that are no spheres as grains with shells: a body of surface A and volume V is A^3 / (36 pi V^2) equal spheres
// of radius 3 V / A, which have its surface, volume and mass. One of them is computed; what reaches the body is shared
// among all, what it holds and gives off is all of theirs. Who uses it: conversion. Invariant: a sphere is one sphere,
// with the same bits.
#pragma once

#include <vector>

#include "core/scene/scene.hpp"

namespace talus {

struct EqualSpheres {
  double radius = 0;  ///< at scale 1 [m]
  double number = 1;  ///< at least 1: a ball has the least surface
};

/// By shape of the scene.
std::vector<EqualSpheres> equal_spheres(const Scene& scene);

/// Smallest radius of these of any grain that the scene's sources make [m].
double smallest_of_equal_spheres(const Scene& scene, const std::vector<EqualSpheres>& shapes, double smallest_row);

}  // namespace talus
