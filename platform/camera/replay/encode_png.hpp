// Gray images as PNG files.
#pragma once

#include <filesystem>

#include "base/image_view.hpp"

namespace polhode::platform {

/// 8 or 16 bits, without loss. @throws RunFailure when the disk does not take it.
void write_png(const std::filesystem::path& file, const ImageView& image);

}  // namespace polhode::platform
