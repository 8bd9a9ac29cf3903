// One oblique impact integrated apart from the engine: equations of motion of two spheres (or a sphere and a plane) in
// three dimensions with the contact laws as differential equations, by Runge-Kutta steps so small that what is left of
// their error does not count. It shares no code with the kernels. Who calls it: oblique_test.cpp.
#pragma once

#include "core/base/types.hpp"

namespace talus::verification {

/// State of one body; a plane is a body of infinite mass and radius 0 whose contact normal is fixed.
struct Body {
  Vec3 v, w;  ///< [m/s], [rad/s]
  double r = 0, m = 0;
};

struct ObliqueLaw {
  bool hertz = false;
  bool partial_slip = false;  ///< two rings of the contact area, as kernels/models/partial_slip.hpp; Hertz only
  double kn = 0, kt = 0;      ///< linear: [N/m]; Hertz: 4/3 E*, 8 G* [Pa]
  double gn = 0, gt = 0;      ///< linear: rates [1/s]; Hertz: alpha and its tangential part [-]
  double mu = 0;
  double rolling = 0, viscous = 0, twisting = 0, torsion = 0;  ///< as kernels/models/moments.hpp
};

struct ObliqueResult {
  Vec3 va, wa, vb, wb;
};

/// From the instant of touch (normal n from b to a) to the end of the contact; `contact`: its usual duration [s].
ObliqueResult oblique_reference(const ObliqueLaw& law, const Body& a, const Body& b, Vec3 n, double contact,
                                int steps = 20000);

}  // namespace talus::verification
