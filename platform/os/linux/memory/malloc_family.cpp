// The malloc family of a program that links this file: operator new and every shared library come
// with it.
#include <errno.h>
#include <stdlib.h>

#include <cstdint>
#include <cstring>

#include "os/linux/memory/region.hpp"

namespace {

using polhode::platform::Heap;
using polhode::platform::region_allocate;
using polhode::platform::region_release;
using polhode::platform::region_resize;
using polhode::platform::region_usable_bytes;

constexpr std::size_t kPage = 4096;

void* allocate(std::size_t bytes, std::size_t alignment = Heap::kAlignment) {
  void* p = region_allocate(bytes, alignment);
  if (p == nullptr) {
    errno = ENOMEM;
  }
  return p;
}

bool overflows(std::size_t count, std::size_t bytes) {
  return bytes != 0 && count > SIZE_MAX / bytes;
}

const bool kDeclared = [] {
  polhode::platform::declare_memory_fixed();
  return true;
}();

}  // namespace

extern "C" {

void* malloc(std::size_t bytes) noexcept { return allocate(bytes); }

void free(void* p) noexcept {
  if (p != nullptr) {
    region_release(p);
  }
}

void* calloc(std::size_t count, std::size_t bytes) noexcept {
  if (overflows(count, bytes)) {
    errno = ENOMEM;
    return nullptr;
  }
  void* p = allocate(count * bytes);
  if (p != nullptr) {
    std::memset(p, 0, count * bytes);
  }
  return p;
}

void* realloc(void* p, std::size_t bytes) noexcept {
  if (p == nullptr) {
    return allocate(bytes);
  }
  if (bytes == 0) {
    region_release(p);
    return nullptr;
  }
  void* resized = region_resize(p, bytes);
  if (resized == nullptr) {
    errno = ENOMEM;
  }
  return resized;
}

void* reallocarray(void* p, std::size_t count, std::size_t bytes) noexcept {
  if (overflows(count, bytes)) {
    errno = ENOMEM;
    return nullptr;
  }
  return realloc(p, count * bytes);
}

void* memalign(std::size_t alignment, std::size_t bytes) noexcept {
  return allocate(bytes, alignment);
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) noexcept {
  return allocate(bytes, alignment);
}
void* valloc(std::size_t bytes) noexcept { return allocate(bytes, kPage); }
void* pvalloc(std::size_t bytes) noexcept {
  return allocate((bytes + kPage - 1) / kPage * kPage, kPage);
}

int posix_memalign(void** out, std::size_t alignment, std::size_t bytes) noexcept {
  if (alignment < sizeof(void*) || (alignment & (alignment - 1)) != 0) {
    return EINVAL;
  }
  void* p = region_allocate(bytes, alignment);
  if (p == nullptr) {
    return ENOMEM;
  }
  *out = p;
  return 0;
}

std::size_t malloc_usable_size(void* p) noexcept {
  return p == nullptr ? 0 : region_usable_bytes(p);
}

}  // extern "C"
