// Deterministic data parallelism: fixed chunks, handed out to threads in any order, results kept by chunk.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace neurframe {

inline constexpr std::int64_t default_chunk_size = 2048;

inline std::int64_t chunk_count(std::int64_t count, std::int64_t chunk_size = default_chunk_size) {
  return (count + chunk_size - 1) / chunk_size;
}

// Calls body(begin, end, chunk) for consecutive ranges that cover [0, count).  The ranges depend on
// chunk_size alone, so whatever body stores under `chunk` is the same for every number of threads.  The
// exception of the lowest failing chunk seen is raised again here.
template <class Body>
void parallel_chunks(std::int64_t count, int threads, const Body& body,
                     std::int64_t chunk_size = default_chunk_size) {
  const std::int64_t chunks = chunk_count(count, chunk_size);
  std::atomic<std::int64_t> next{0};
  std::mutex failure_mutex;
  std::int64_t failed_chunk = chunks;
  std::exception_ptr failure;
  const auto work = [&] {
    for (std::int64_t chunk = next++; chunk < chunks; chunk = next++) {
      try {
        body(chunk * chunk_size, std::min(count, (chunk + 1) * chunk_size), chunk);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(failure_mutex);
        if (chunk < failed_chunk) {
          failed_chunk = chunk;
          failure = std::current_exception();
        }
      }
    }
  };
  std::vector<std::jthread> others;
  const std::int64_t useful = std::min<std::int64_t>(threads, chunks);
  try {
    for (std::int64_t i = 1; i < useful; ++i) others.emplace_back(work);
  } catch (const std::system_error&) {
    // a limit of memory or processes allows no more threads: those that there are do all chunks
  }
  work();
  others.clear();
  if (failure) std::rethrow_exception(failure);
}

// Calls body(i) for every i in [0, count); the calls must not depend on each other.
template <class Body>
void parallel_for(std::int64_t count, int threads, const Body& body) {
  parallel_chunks(count, threads, [&](std::int64_t begin, std::int64_t end, std::int64_t) {
    for (std::int64_t i = begin; i < end; ++i) body(i);
  });
}

// The concatenation, in chunk order, of what body(begin, end, out) appends to its own vector `out`.
template <class Item, class Body>
std::vector<Item> parallel_collect(std::int64_t count, int threads, const Body& body) {
  std::vector<std::vector<Item>> parts(static_cast<std::size_t>(chunk_count(count)));
  parallel_chunks(count, threads, [&](std::int64_t begin, std::int64_t end, std::int64_t chunk) {
    body(begin, end, parts[static_cast<std::size_t>(chunk)]);
  });
  std::size_t total = 0;
  for (const auto& part : parts) total += part.size();
  std::vector<Item> all;
  all.reserve(total);
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

}  // namespace neurframe
