// The list of list policies.
#include "core/base/error.hpp"
#include "scheduler/lists/policies/accumulated.hpp"
#include "scheduler/lists/policies/always.hpp"
#include "scheduler/lists/policies/displacement_history.hpp"
#include "scheduler/lists/policies/fixed.hpp"
#include "scheduler/lists/policies/global_velocity.hpp"
#include "scheduler/lists/policies/local.hpp"
#include "scheduler/lists/policies/mean_subtracted.hpp"
#include "scheduler/lists/policies/neighbourhood.hpp"
#include "scheduler/lists/policies/outer_inner.hpp"
#include "scheduler/lists/policies/paper.hpp"
#include "scheduler/lists/policies/policy.hpp"
#include "scheduler/lists/policies/two_largest.hpp"
#include "scheduler/lists/policies/uniform.hpp"
#include "scheduler/lists/policies/velocity_profile.hpp"

namespace talus {
namespace {

constexpr const Policy* k_policies[] = {
    &policies::k_always,
    &policies::k_paper,
    &policies::k_local,
    &policies::k_uniform,
    &policies::k_two_largest,
    &policies::k_accumulated,
    &policies::k_global_velocity,
    &policies::k_neighbourhood,
    &policies::k_mean_subtracted,
    &policies::k_velocity_profile,
    &policies::k_displacement_history,
    &policies::k_outer_inner,
    &policies::k_fixed,
};

}  // namespace

std::span<const Policy* const> list_policies() { return k_policies; }

const Policy& policy_of(ListPolicy policy) {
  for (const Policy* p : k_policies)
    if (p->word == policy) return *p;
  throw Error(ErrorCode::scene, "list policy '" + std::string(enum_word(policy)) + "' has no rules");
}

}  // namespace talus
