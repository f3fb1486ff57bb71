// A target's model as it is stored: a head with its length and CRC-32, then its content. The same
// octets on every machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "pipeline/target_model.hpp"

namespace polhode::platform {

/// In front of the content.
inline constexpr std::size_t kModelHeadOctets = 24;

/// Octets that no model is longer than.
std::size_t model_octets_max();

/// Does it begin as a model? kModelHeadOctets of it are enough.
bool begins_as_model(std::span<const std::uint8_t> octets);

/// @param out  at least model_octets_max() long.
/// @return octets written; 0 without a map.
std::size_t save_model_octets(const Component& component, std::span<std::uint8_t> out);

/// Into a component that has just been created.
/// @return why it is not taken, and the component is as it was created; empty when it is.
std::string load_model_octets(std::span<const std::uint8_t> octets,
                              Component* component,
                              TargetModelFacts* facts);

}  // namespace polhode::platform
