// JPEG by libjpeg-turbo. Gray is the file's own luminance channel: no colour conversion is made.
#include <turbojpeg.h>

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
  return failed != 0 ? Refusal(reason(decoder)) : std::nullopt;
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
