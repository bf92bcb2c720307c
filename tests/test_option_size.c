/* Options of callers that were compiled against other headers. */
#include "golden_support.h"

#include "core/option_size.h"

typedef struct options {
  size_t size;
  int first, second;
} options;

typedef struct newer {
  options known;
  double more;
} newer;

static hetab_status take(hetab_context *ctx, const void *given, options *out) {
  HETAB_OPTIONS(ctx, options, own, given);
  *out = own;
  return HETAB_OK;
}

static void test_none(void **state) {
  options o = {.first = 7};
  assert_ok(*state, take(*state, NULL, &o));
  assert_true(o.first == 0 && o.second == 0);
}

static void test_same(void **state) {
  options o, given = {.first = 1, .second = 2};
  assert_ok(*state, take(*state, &given, &o)); /* size 0: this header's */
  assert_true(o.first == 1 && o.second == 2);
  given.size = sizeof given;
  assert_ok(*state, take(*state, &given, &o));
  assert_true(o.first == 1 && o.second == 2);
}

/* Members that an older caller's struct does not have are 0, whatever lies behind it. */
static void test_older(void **state) {
  options o, given = {.size = offsetof(options, second), .first = 1, .second = 2};
  assert_ok(*state, take(*state, &given, &o));
  assert_true(o.first == 1 && o.second == 0);
}

static void test_newer(void **state) {
  static const char *const words[] = {"options", "one version", NULL};
  options o;
  newer given = {.known = {.size = sizeof given, .first = 1}};
  assert_ok(*state, take(*state, &given, &o));
  assert_int_equal(o.first, 1);
  given.more = 0.5;
  assert_fails(*state, take(*state, &given, &o), HETAB_ERR_ARGUMENT, words);
}

int main(void) {
  const struct CMUnitTest tests[] = {TEST(test_none), TEST(test_same), TEST(test_older),
                                     TEST(test_newer)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
