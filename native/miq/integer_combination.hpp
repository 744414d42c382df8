// Exact integer combinations of integer symbols, and the solution of linear equations between them.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace neurframe {

// sum of coefficient * symbol + constant; terms sorted by symbol, no zero coefficient
struct IntegerCombination {
  std::vector<std::pair<int, int64_t>> terms;
  int64_t constant = 0;

  bool is_zero() const { return terms.empty() && constant == 0; }
};

IntegerCombination symbol(int index);

// a + factor * b
IntegerCombination sum(const IntegerCombination& a, const IntegerCombination& b, int64_t factor = 1);

IntegerCombination scaled(const IntegerCombination& a, int64_t factor);

// The integer solutions of homogeneous or inhomogeneous equations between integer symbols, parametrised by
// free symbols.  Symbols may be added at any time; an equation takes effect at once.
class IntegerEquations {
 public:
  // a fresh symbol, free until an equation binds it
  int add_symbol();

  // Imposes row = 0.  False if no integers satisfy it together with the earlier rows: the row is then left
  // out. Pivots with coefficient +-1 are preferred; without one, Euclid's algorithm on the columns makes one.
  bool impose(const IntegerCombination& row);

  // the combination in free symbols only
  IntegerCombination resolve(const IntegerCombination& a) const;

 private:
  void eliminate(int pivot, const IntegerCombination& value);
  bool impose_by_euclid(IntegerCombination row);

  int symbol_count_ = 0;
  std::map<int, IntegerCombination> value_;        // bound symbol -> combination of free symbols
  std::map<int, std::vector<int>> users_of_free_;  // free symbol -> bound symbols that may mention it
};

}  // namespace neurframe
