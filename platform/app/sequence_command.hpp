// polhode sequence: a sequence's tables as JSON, for programs that evaluate or show a replay. So
// there is one reader of them for all programs.
#pragma once

#include <filesystem>

namespace polhode::platform {

struct SequenceArguments {
  std::filesystem::path sequence;
  bool any_lens = false;  ///< `intrinsics: auto` is no reason to refuse
};

/// Prints data.csv and sensor.yaml as one JSON object. Its texts are
/// those of json_text().
/// @throws UnusableInput as open_sequence() does for the tables; images are not looked at.
void print_sequence(const SequenceArguments& arguments);

}  // namespace polhode::platform
