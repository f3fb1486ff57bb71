// JPEG by libjpeg-turbo. Gray is the file's own luminance channel: no colour conversion is made.
#include <turbojpeg.h>

#include <cstddef>
#include <memory>

#include "camera/replay/decode.hpp"

namespace polhode::platform {
namespace {

struct Close {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using Decoder = std::unique_ptr<void, Close>;

std::string reason(const Decoder& decoder) {
  return std::string("JPEG: ") + tjGetErrorStr2(decoder.get());
}

/// In how many scans a picture comes, by the markers up to the first one.
struct Scans {
  std::size_t components = 0;
  bool several = false;
};

Scans scans_of(Octets file) {
  Scans scans;
  bool progressive = false;
  std::size_t at = 2;  // after the marker that begins the image
  while (at + 10 <= file.size() && file[at] == 0xFF) {
    const unsigned marker = file[at + 1];
    const bool alone = marker == 0x01 || (marker >= 0xD0 && marker <= 0xD8);
    if (marker == 0xFF || alone) {
      at += alone ? 2 : 1;  // 0xFF before a marker fills up
      continue;
    }
    if (marker == 0xDA) {  // the first scan
      scans.several = progressive || file[at + 4] < scans.components;
      return scans;
    }
    const bool of_frame =
        marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (of_frame) {
      progressive = (marker & 3U) == 2;
      scans.components = file[at + 9];
    }
    at += 2 + (std::size_t{file[at + 2]} << 8U | file[at + 3]);
  }
  return scans;  // whatever it is: the decoder refuses it
}

/// The library keeps all coefficients, 16 bits each, until the last scan; a component is rounded up
/// to whole groups of blocks, 32 pixels at most.
std::size_t coefficient_octets(Octets file, const ImageHeader& header) {
  constexpr std::size_t kGroup_px = 32;
  const Scans scans = scans_of(file);
  const std::size_t samples = (static_cast<std::size_t>(header.width_px) + kGroup_px) *
                              (static_cast<std::size_t>(header.height_px) + kGroup_px);
  return scans.several ? 2 * scans.components * samples : 0;
}

Refusal header_with(const Decoder& decoder, Octets file, ImageHeader& header) {
  int subsampling = 0;
  int colour_space = 0;
  const int failed = tjDecompressHeader3(decoder.get(),
                                         file.data(),
                                         static_cast<unsigned long>(file.size()),
                                         &header.width_px,
                                         &header.height_px,
                                         &subsampling,
                                         &colour_space);
  header.format = PixelFormat::kGray8;
  if (failed != 0) {
    return reason(decoder);
  }
  header.decoder_octets = coefficient_octets(file, header);
  return std::nullopt;
}

}  // namespace

Refusal jpeg_header(Octets file, ImageHeader& header) {
  const Decoder decoder(tjInitDecompress());
  return header_with(decoder, file, header);
}

Refusal jpeg_decode(Octets file, DecodedImage& image) {
  const Decoder decoder(tjInitDecompress());
  // A file that ends early is only a warning to the library, which paints the rest gray. Here it is
  // a refusal. The accurate transform gives the same pixels whatever vector unit the machine has.
  const int failed = tjDecompress2(decoder.get(),
                                   file.data(),
                                   static_cast<unsigned long>(file.size()),
                                   image.pixels.data(),
                                   image.header.width_px,
                                   0,
                                   image.header.height_px,
                                   TJPF_GRAY,
                                   TJFLAG_STOPONWARNING | TJFLAG_ACCURATEDCT);
  return failed != 0 ? Refusal(reason(decoder)) : std::nullopt;
}

}  // namespace polhode::platform
