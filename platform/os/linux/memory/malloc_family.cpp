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
using polhode::platform::region_usable_octets;

constexpr std::size_t kPage = 4096;

void* allocate(std::size_t octets, std::size_t alignment = Heap::kAlignment) {
  void* p = region_allocate(octets, alignment);
  if (p == nullptr) {
    errno = ENOMEM;
  }
  return p;
}

bool overflows(std::size_t count, std::size_t octets) {
  return octets != 0 && count > SIZE_MAX / octets;
}

const bool kDeclared = [] {
  polhode::platform::declare_memory_fixed();
  return true;
}();

}  // namespace

extern "C" {

void* malloc(std::size_t octets) noexcept { return allocate(octets); }

void free(void* p) noexcept {
  if (p != nullptr) {
    region_release(p);
  }
}

void* calloc(std::size_t count, std::size_t octets) noexcept {
  if (overflows(count, octets)) {
    errno = ENOMEM;
    return nullptr;
  }
  void* p = allocate(count * octets);
  if (p != nullptr) {
    std::memset(p, 0, count * octets);
  }
  return p;
}

void* realloc(void* p, std::size_t octets) noexcept {
  if (p == nullptr) {
    return allocate(octets);
  }
  if (octets == 0) {
    region_release(p);
    return nullptr;
  }
  void* resized = region_resize(p, octets);
  if (resized == nullptr) {
    errno = ENOMEM;
  }
  return resized;
}

void* reallocarray(void* p, std::size_t count, std::size_t octets) noexcept {
  if (overflows(count, octets)) {
    errno = ENOMEM;
    return nullptr;
  }
  return realloc(p, count * octets);
}

void* memalign(std::size_t alignment, std::size_t octets) noexcept {
  return allocate(octets, alignment);
}
void* aligned_alloc(std::size_t alignment, std::size_t octets) noexcept {
  return allocate(octets, alignment);
}
void* valloc(std::size_t octets) noexcept { return allocate(octets, kPage); }
void* pvalloc(std::size_t octets) noexcept {
  return allocate((octets + kPage - 1) / kPage * kPage, kPage);
}

int posix_memalign(void** out, std::size_t alignment, std::size_t octets) noexcept {
  if (alignment < sizeof(void*) || (alignment & (alignment - 1)) != 0) {
    return EINVAL;
  }
  void* p = region_allocate(octets, alignment);
  if (p == nullptr) {
    return ENOMEM;
  }
  *out = p;
  return 0;
}

std::size_t malloc_usable_size(void* p) noexcept {
  return p == nullptr ? 0 : region_usable_octets(p);
}

}  // extern "C"
