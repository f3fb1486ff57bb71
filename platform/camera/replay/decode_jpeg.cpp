// JPEG by libjpeg-turbo. Gray is the file's own luminance channel: no colour conversion is made.
// The library leaves by longjmp, so every function that sets a jump holds only plain variables that
// were there before the jump was set.
#include <csetjmp>
#include <cstddef>

#include "camera/jpeg_remarks.hpp"
#include "camera/replay/decode.hpp"

namespace polhode::platform {
namespace {

/// Owns the library's decoder for one pass over one file.
struct Decoder {
  jpeg_decompress_struct jpeg{};
  jpeg_error_mgr errors{};
  std::jmp_buf failed{};
  Bytes file;
  char message[JMSG_LENGTH_MAX] = {};

  explicit Decoder(Bytes bytes) : file(bytes) {
    jpeg.err = jpeg_std_error(&errors);
    errors.error_exit = abort_decoding;
    errors.emit_message = remark;
    jpeg.client_data = this;
    jpeg_create_decompress(&jpeg);
  }
  ~Decoder() { jpeg_destroy_decompress(&jpeg); }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;

  [[nodiscard]] std::string reason() const { return std::string("JPEG: ") + message; }

  bool read_header() {
    if (setjmp(failed) != 0) {  // NOLINT(cert-err52-cpp): the library's way out of an error
      return false;
    }
    jpeg_mem_src(&jpeg, file.data(), static_cast<unsigned long>(file.size()));
    (void)jpeg_read_header(&jpeg, TRUE);
    return true;
  }

  /// After read_header(). The accurate transform gives the same pixels whatever vector unit the
  /// machine has.
  bool read_rows(std::uint8_t* pixels) {
    if (setjmp(failed) != 0) {  // NOLINT(cert-err52-cpp)
      return false;
    }
    jpeg.out_color_space = JCS_GRAYSCALE;
    jpeg.dct_method = JDCT_ISLOW;
    (void)jpeg_start_decompress(&jpeg);
    while (jpeg.output_scanline < jpeg.output_height) {
      JSAMPROW row = pixels + std::size_t{jpeg.output_scanline} * jpeg.output_width;
      (void)jpeg_read_scanlines(&jpeg, &row, 1);
    }
    (void)jpeg_finish_decompress(&jpeg);
    return true;
  }

 private:
  [[noreturn]] static void abort_decoding(j_common_ptr jpeg) {
    auto* decoder = static_cast<Decoder*>(jpeg->client_data);
    jpeg->err->format_message(jpeg, decoder->message);
    std::longjmp(decoder->failed, 1);
  }
  static void remark(j_common_ptr jpeg, int level) {
    const auto* decoder = static_cast<Decoder*>(jpeg->client_data);
    if (level < 0 && indicates_damage(decoder->jpeg, decoder->file.data())) {
      abort_decoding(jpeg);
    }
  }
};

/// In how many scans an image comes, by the markers up to the first one.
struct Scans {
  std::size_t components = 0;
  bool several = false;
};

Scans scans_of(Bytes file) {
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
std::size_t coefficient_bytes(Bytes file, const ImageHeader& header) {
  constexpr std::size_t kGroup_px = 32;
  const Scans scans = scans_of(file);
  const std::size_t samples = (static_cast<std::size_t>(header.width_px) + kGroup_px) *
                              (static_cast<std::size_t>(header.height_px) + kGroup_px);
  return scans.several ? 2 * scans.components * samples : 0;
}

}  // namespace

Refusal jpeg_header(Bytes file, ImageHeader& header) {
  Decoder decoder(file);
  if (!decoder.read_header()) {
    return decoder.reason();
  }
  const J_COLOR_SPACE colours = decoder.jpeg.jpeg_color_space;
  if (colours == JCS_CMYK || colours == JCS_YCCK || colours == JCS_UNKNOWN) {
    return "JPEG: colours for print (CMYK) or of an unknown kind; allowed are gray, YCbCr and RGB";
  }
  header = {.width_px = static_cast<int>(decoder.jpeg.image_width),
            .height_px = static_cast<int>(decoder.jpeg.image_height),
            .format = PixelFormat::kGray8};
  header.decoder_bytes = coefficient_bytes(file, header);
  return std::nullopt;
}

Refusal jpeg_decode(Bytes file, DecodedImage& image) {
  Decoder decoder(file);
  if (!decoder.read_header() || !decoder.read_rows(image.pixels.data())) {
    return decoder.reason();
  }
  return std::nullopt;
}

}  // namespace polhode::platform
