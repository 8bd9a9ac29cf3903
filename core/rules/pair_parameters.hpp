// The forces of kernels/models and the coefficients of one material pair as they read them. Plain numbers: units
// compiled for different instruction sets share them. Who fills them: a law of core/rules/laws.
#pragma once

#include "core/base/words.hpp"

namespace talus {

/// In the order of KernelTable::law.
TALUS_WORDS(LawForce, linear, hertz_mindlin, jkr, partial_slip)

struct PairParameters {
  double kn = 0, kt = 0;  ///< linear: [N/m]; Hertz: 4/3 E* and 8 G* [Pa]
  double gn = 0, gt = 0;  ///< linear: rates [1/s], or 2 beta (rate = gn sqrt(k/m_eff)) by restitution; Hertz: alpha [-]
  double mu = 0;          ///< friction [-]
  double w = 0;           ///< JKR: work of adhesion [J/m2]
};

}  // namespace talus
