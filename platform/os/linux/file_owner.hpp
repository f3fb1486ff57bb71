// Whose an open file is.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>

namespace polhode::platform {

/// @param forbidden  of the mode: what nobody but the owner may do, as S_IWGRP | S_IWOTH.
/// @return empty; or why this is no file of this process's user's own.
std::string problem_of_owner(int descriptor, mode_t forbidden);

/// Of a file that may not be opened: "belongs to user 0, not to 990". Empty: it is this user's own,
/// or it is not there.
std::string stranger_at(const std::filesystem::path& file);

}  // namespace polhode::platform
