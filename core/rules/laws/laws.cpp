// The list of contact laws.
#include "core/base/error.hpp"
#include "core/rules/laws/hertz_mindlin.hpp"
#include "core/rules/laws/hertz_tsuji.hpp"
#include "core/rules/laws/jkr.hpp"
#include "core/rules/laws/law.hpp"
#include "core/rules/laws/linear.hpp"

namespace talus {
namespace {

constexpr const Law* k_laws[] = {&laws::k_linear, &laws::k_hertz_mindlin, &laws::k_hertz_tsuji, &laws::k_jkr};

}  // namespace

std::span<const Law* const> contact_laws() { return k_laws; }

const Law& law_of(ContactModel model) {
  for (const Law* law : k_laws)
    if (law->model == model) return *law;
  throw Error(ErrorCode::scene, "contact model '" + std::string(enum_word(model)) + "' without a law");
}

const LawInfo& law_info(ContactModel model) { return law_of(model).force; }

const LawInfo& law_info(const ContactLaw& law) {
  const Law& l = law_of(law.model);
  return law.partial_slip ? l.partial_slip : l.force;
}

std::string laws_where(bool (*holds)(const Law&), std::string_view before) {
  std::string words;
  for (const Law* law : k_laws) {
    if (!holds(*law)) continue;
    words += words.empty() ? before : "|";
    words += enum_word(law->model);
  }
  return words;
}

std::string pair_name(const Scene& scene, int a, int b) {
  return scene.materials[static_cast<std::size_t>(a)].name + " - " + scene.materials[static_cast<std::size_t>(b)].name;
}

}  // namespace talus
