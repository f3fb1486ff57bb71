#include "transport/address.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/un.h>

#include <charconv>

#include "errors.hpp"

namespace polhode::platform {
namespace {

constexpr std::string_view kAllowed =
    "unix:PATH, udp:PORT, udp:HOST:PORT with a numeric IPv4 HOST, shm:/NAME, file:PATH";
constexpr std::size_t kShmNameMax = 200;

[[noreturn]] void refuse(std::string_view text, std::string_view why) {
  throw UnusableInput(fmt::format("address '{}': {}; allowed are {}", text, why, kAllowed));
}

std::uint16_t port_of(std::string_view digits, std::string_view text) {
  std::uint16_t port = 0;
  const auto end = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  if (end.ec != std::errc{} || end.ptr != digits.data() + digits.size() || port == 0) {
    refuse(text, "the port is not 1 .. 65535");
  }
  return port;
}

sockaddr_in udp_of(std::string_view rest, std::string_view text) {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const std::size_t colon = rest.rfind(':');
  if (colon != std::string_view::npos &&
      inet_pton(AF_INET, std::string(rest.substr(0, colon)).c_str(), &out.sin_addr) != 1) {
    refuse(text, "the host is not a numeric IPv4 address");
  }
  out.sin_port =
      htons(port_of(colon == std::string_view::npos ? rest : rest.substr(colon + 1), text));
  return out;
}

}  // namespace

Address parse_address(std::string_view text) {
  const std::size_t colon = text.find(':');
  const std::string_view kind = text.substr(0, colon);
  const std::string_view rest =
      colon == std::string_view::npos ? std::string_view() : text.substr(colon + 1);
  Address out{.text = std::string(text), .path = std::string(rest)};
  if (colon == std::string_view::npos) {
    refuse(text, "its kind is missing");
  }
  if (rest.empty()) {
    refuse(text, "nothing follows its kind");
  }
  if (kind == "unix") {
    out.kind = AddressKind::kUnix;
    if (rest.size() >= sizeof(sockaddr_un::sun_path)) {
      refuse(text,
             fmt::format("the path has more than {} octets", sizeof(sockaddr_un::sun_path) - 1));
    }
  } else if (kind == "udp") {
    out.kind = AddressKind::kUdp;
    out.udp = udp_of(rest, text);
  } else if (kind == "shm") {
    out.kind = AddressKind::kShm;
    if (rest[0] != '/' || rest.size() < 2 || rest.size() > kShmNameMax ||
        rest.find('/', 1) != std::string_view::npos) {
      refuse(text, "the name has one slash, at its front");
    }
  } else if (kind == "file") {
    out.kind = AddressKind::kFile;
  } else {
    refuse(text, "unknown kind");
  }
  return out;
}

}  // namespace polhode::platform
