// What libgcc would find out about the processor, for a program whose functions of several clones are to be those for
// any x86-64. Their resolvers ask this, and not glibc, whose tunables therefore change nothing.
// The names and layouts are those of GCC's libgcc/config/i386/cpuinfo.c.
extern "C" {
struct {
  unsigned vendor, type, subtype, features[1];
} __cpu_model;
unsigned __cpu_features2[8];
int __cpu_indicator_init() {
  return 0;
}
}
