#include "camera/jpeg_remarks.hpp"

// The library's numbers of its messages.
#include <jerror.h>

#include <algorithm>

namespace polhode::platform {
namespace {

/// Before a marker; the library has passed over them. A few, or any number of one value, as
/// cameras fill up their buffers. More of changing values are data that was not understood.
bool are_stray(const jpeg_decompress_struct& decoder, const JOCTET* file) {
  constexpr long kFew = 16;
  constexpr long kMarker = 2;  // bytes of it, already read
  const long count = decoder.err->msg_parm.i[0];
  const JOCTET* end = decoder.src->next_input_byte - kMarker;
  if (count <= kFew) {
    return true;
  }
  if (end - file < count) {
    return false;
  }
  const JOCTET* begin = end - count;
  return std::all_of(begin, end, [begin](JOCTET byte) { return byte == *begin; });
}

}  // namespace

bool indicates_damage(const jpeg_decompress_struct& decoder, const JOCTET* file) {
  switch (decoder.err->msg_code) {
    case JWRN_EXTRANEOUS_DATA:
      return !are_stray(decoder, file);
    case JWRN_JPEG_EOF:
      // Missing data has a remark of its own; missing scans have none.
      return decoder.progressive_mode != 0 || decoder.comps_in_scan < decoder.num_components;
    case JWRN_JFIF_MAJOR:
    case JWRN_ADOBE_XFORM:
    case JWRN_BOGUS_ICC:
      return false;
    default:
      return true;
  }
}

}  // namespace polhode::platform
