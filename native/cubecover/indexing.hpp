// Element access by the `int` indices that the mesh arrays hold.
#pragma once

#include <cstddef>

namespace neurframe {

template <class Container>
constexpr decltype(auto) at(Container& container, int index) {
  return container[static_cast<std::size_t>(index)];
}

template <class Container>
constexpr decltype(auto) at(const Container& container, int index) {
  return container[static_cast<std::size_t>(index)];
}

}  // namespace neurframe
