#include "os/linux/file_faults.hpp"

#include <cerrno>
#include <system_error>

#include "errors.hpp"
#include "os/linux/file_owner.hpp"

namespace polhode::platform {
namespace {

bool is_of_the_machine(int error) {
  switch (error) {
    case EADDRINUSE:
    case EDQUOT:
    case EFBIG:
    case EIO:
    case EMFILE:
    case ENFILE:
    case ENOBUFS:
    case ENOLCK:
    case ENOMEM:
    case ENOSPC:
    case EROFS:
    case ETXTBSY:
      return true;
    default:
      return false;
  }
}

}  // namespace

void fail_at_start(const std::string& what, int error) {
  const std::string text = what + ": " + std::generic_category().message(error);
  if (is_of_the_machine(error)) {
    throw RunFailure(text);
  }
  throw UnusableInput(text);
}

void fail_to_open(const std::filesystem::path& file, const std::string& what, int error) {
  const bool is_refused = error == EACCES || error == EPERM;
  const std::string stranger = is_refused ? stranger_at(file) : "";
  if (!stranger.empty()) {
    throw UnusableInput(what + ": " + stranger + "; give it to that user, or remove it");
  }
  fail_at_start(what, error);
}

}  // namespace polhode::platform
