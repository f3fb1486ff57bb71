#include "os/linux/file_faults.hpp"

#include <cerrno>
#include <system_error>

#include "errors.hpp"

namespace polhode::platform {
namespace {

bool is_of_the_machine(int error) {
  switch (error) {
    case EDQUOT:
    case EFBIG:
    case EIO:
    case EMFILE:
    case ENFILE:
    case ENOLCK:
    case ENOMEM:
    case ENOSPC:
    case EROFS:
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

}  // namespace polhode::platform
