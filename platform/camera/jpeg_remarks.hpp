// Classifies libjpeg's warnings while it decodes: is the image damaged, or complete?
#pragma once

#include <cstdio>  // jpeglib.h needs FILE

#include <jpeglib.h>

namespace polhode::platform {

/// For emit_message() with a level under 0, of an image that is read from memory. Harmless are
/// stray bytes before a restart or end marker, an end marker that is missing where all scans are
/// there, and odd headers. Missing or undecodable data is damage.
/// @param file  the first byte of the image
bool indicates_damage(const jpeg_decompress_struct& decoder, const JOCTET* file);

}  // namespace polhode::platform
