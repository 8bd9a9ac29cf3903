// Kernels of a number type that counts its arithmetic: the flops, divisions and roots of the microbenchmarks come from
// the kernels' own source. Who calls it: count_once() in kernels_measure.hpp. Invariant: results are those of the
// scalar kernels, so a counted call leaves the state as a timed one does.
#include "kernels/isa/table.hpp"
#include "perf/kernels_measure.hpp"

namespace talus::perf {

namespace {

Operations g_done;

/// One lane that counts; converts from the scalar lane, so that everything not named below is the scalar code.
struct Counted : simd::One {
  Counted() = default;
  Counted(simd::One a) : One(a) {}
  explicit Counted(double a) : One{a} {}
};
Counted counted(double result) {
  ++g_done.flops;
  return Counted(result);
}
Counted operator+(Counted a, Counted b) { return counted(a.v + b.v); }
Counted operator-(Counted a, Counted b) { return counted(a.v - b.v); }
Counted operator*(Counted a, Counted b) { return counted(a.v * b.v); }
Counted operator/(Counted a, Counted b) {
  ++g_done.divisions;
  return counted(a.v / b.v);
}

/// The scalar kernels' primitives, counted. Signatures are left open where only the number of operations matters.
template <class Base>
struct CountingOver : Base {
  using B = Counted;
  using R4 = typename Base::R4;
  using R8 = typename Base::R8;
  static constexpr const char* name = "counting";
  static B set(double a) { return B(a); }
  static B load(const double* p) { return B(*p); }
  static B sqrt(B a) {
    ++g_done.roots;
    return counted(__builtin_sqrt(a.v));
  }
  static B abs(B a) { return B(__builtin_fabs(a.v)); }
  static B copysign(B size, B sign) { return B(__builtin_copysign(size.v, sign.v)); }
  static B select(bool m, B a, B b) { return m ? a : b; }
  static B subtract_where(bool m, B a, B b) {
    const B d = a - b;
    return m ? d : a;
  }
  template <class... A>
  static void pair_rows4(A... a) {
    g_done.flops += 4;
    Base::pair_rows4(a...);
  }
  template <class... A>
  static void pair_rows8(A... a) {
    g_done.flops += 8;
    Base::pair_rows8(a...);
  }
  static void scatter8(double* f, const std::int32_t* a, const std::int32_t* b, const B* r, unsigned both) {
    g_done.flops += (both & 1U) != 0 ? 16 : 8;
    Base::scatter8(f, a, b, r, both);
  }
  static void scatter4(double* f, const std::int32_t* a, const std::int32_t* b, const B* r, unsigned both) {
    g_done.flops += (both & 1U) != 0 ? 8 : 4;
    Base::scatter4(f, a, b, r, both);
  }
  static R4 add4(const R4& a, const R4& b) { return g_done.flops += 4, Base::add4(a, b); }
  static R4 sub4(const R4& a, const R4& b) { return g_done.flops += 4, Base::sub4(a, b); }
  static R4 mul4(const R4& a, const R4& b) { return g_done.flops += 4, Base::mul4(a, b); }
  static R8 add8(const R8& a, const R8& b) { return g_done.flops += 8, Base::add8(a, b); }
  static R8 mul8(const R8& a, const R8& b) { return g_done.flops += 8, Base::mul8(a, b); }
  static double norm3(const R4& a) { return g_done.flops += 5, Base::norm3(a); }
  static float fadd(float a, float b) { return ++g_done.flops, a + b; }
  static float fsub(float a, float b) { return ++g_done.flops, a - b; }
  static float fmul(float a, float b) { return ++g_done.flops, a * b; }
};
using Counting = CountingOver<simd::Scalar>;

constinit const KernelTable k_counting = kernels::make_table<Counting>();

}  // namespace

const KernelTable& counting_kernels() { return k_counting; }
Operations& operations() { return g_done; }

}  // namespace talus::perf
