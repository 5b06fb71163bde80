#include "counted.h"

void counted(const std::function<void()>& operation, int times) {
  for (int k = 0; k < times; ++k) operation();
}
