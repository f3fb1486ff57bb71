// What one pass has learnt of a target, for the next one.
#include <string>

#include "capi/handle.hpp"
#include "capi/polhode.h"
#include "capi/problem.hpp"
#include "model_octets.hpp"

using polhode::capi::guarded;
using polhode::capi::write_problem;

size_t polhode_model_octets_max(void) { return polhode::platform::model_octets_max(); }

polhode_status polhode_save_model(const polhode_component* component,
                                  uint8_t* out,
                                  size_t octets,
                                  size_t* written) {
  if (component == nullptr || out == nullptr || written == nullptr) {
    return POLHODE_BAD_ARGUMENT;
  }
  if (component->failed) {
    return POLHODE_FAILED;
  }
  if (octets < polhode::platform::model_octets_max()) {
    return POLHODE_MEMORY_TOO_SMALL;
  }
  return guarded([&] {
    *written = polhode::platform::save_model_octets(*component->component, std::span(out, octets));
    return polhode_status{*written > 0 ? POLHODE_OK : POLHODE_NOT_KNOWN};
  });
}

polhode_status polhode_load_model(polhode_component* component,
                                  const uint8_t* octets,
                                  size_t length,
                                  char* problem,
                                  size_t problem_octets) {
  if (component == nullptr || octets == nullptr || component->component->next_step() != 0) {
    write_problem("component or octets: null, or it has stepped", problem, problem_octets);
    return POLHODE_BAD_ARGUMENT;
  }
  return guarded([&] {
    polhode::TargetModelFacts facts;
    const std::string refusal = polhode::platform::load_model_octets(
        std::span(octets, length), component->component, &facts);
    write_problem(refusal, problem, problem_octets);
    return polhode_status{refusal.empty() ? POLHODE_OK : POLHODE_BAD_MODEL};
  });
}
