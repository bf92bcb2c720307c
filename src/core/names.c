/* Words for the enumerations that files and reports name. */
#include <hetab/types.h>

const char *hetab_method_name(hetab_method method) {
  static const char *const names[] = {"rows", "series", "literal"};
  return (size_t)method < 3 ? names[method] : "unknown";
}

const char *hetab_precision_name(hetab_precision precision) {
  return precision == HETAB_DOUBLE ? "double" : "float";
}
