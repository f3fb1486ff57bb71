// A packet's fields as JSON and as text, by the field table.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "bus/fields.hpp"

namespace polhode::platform {

/// One value: a number, an enumeration's word, an array, a text; null where its flag is down. Flags
/// become `pose_valid` and the like: one entry each, named as in the field table with "_valid"
/// behind the names of validity flags.
nlohmann::ordered_json fields_json(const bus::Layout& layout, const void* packet);

/// The same in one line for people: "name=value" with few digits; what is invalid is left out.
std::string fields_text(const bus::Layout& layout, const void* packet);

/// Entry of a flag in JSON: "pose_valid", but "scale_known".
std::string flag_key(const bus::Layout& layout, std::size_t bit);

}  // namespace polhode::platform
