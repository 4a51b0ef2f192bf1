/* Times Embree 4's single-ray queries on rays given as o, d, t_max. It is compiled and called by embree_compare.py.
   It declares the part of Embree's public C interface that it uses, so that no header has to be installed. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct __attribute__((aligned(16))) {
  float ox, oy, oz, tnear, dx, dy, dz, time, tfar;
  unsigned mask, id, flags;
} RTCRay;
typedef struct __attribute__((aligned(16))) {
  RTCRay ray;
  float ngx, ngy, ngz, u, v;
  unsigned prim, geom, inst[8];
} RTCRayHit;

extern void *rtcNewDevice(const char *);
extern void *rtcNewScene(void *);
extern void *rtcNewGeometry(void *, int);
extern void *rtcSetNewGeometryBuffer(void *, int, unsigned, int, size_t, size_t);
extern void rtcCommitGeometry(void *);
extern unsigned rtcAttachGeometry(void *, void *);
extern void rtcCommitScene(void *);
extern void rtcIntersect1(void *, RTCRayHit *, void *);
extern void rtcOccluded1(void *, RTCRay *, void *);

void *build(const float *corners, size_t triangles) {
  void *device = rtcNewDevice("threads=1");
  void *scene = rtcNewScene(device);
  void *geometry = rtcNewGeometry(device, 0);
  float *vertex = rtcSetNewGeometryBuffer(geometry, 1, 0, 0x9003, 12, triangles * 3);
  unsigned *index = rtcSetNewGeometryBuffer(geometry, 0, 0, 0x5003, 12, triangles);
  memcpy(vertex, corners, triangles * 36);
  for (size_t i = 0; i < triangles * 3; i++) index[i] = (unsigned)i;
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcCommitScene(scene);
  return scene;
}

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

/* Returns the seconds of one pass over n rays of 7 floats and counts the hits. */
double pass(void *scene, const float *rays, size_t n, int shadow, size_t *hits) {
  size_t found = 0;
  double start = now();
  for (size_t i = 0; i < n; i++) {
    const float *r = rays + 7 * i;
    RTCRayHit q;
    q.ray = (RTCRay){r[0], r[1], r[2], 0.0f, r[3], r[4], r[5], 0.0f, r[6], 0xffffffffu, 0, 0};
    if (shadow) {
      rtcOccluded1(scene, &q.ray, 0);
      found += q.ray.tfar < 0.0f;
    } else {
      q.geom = q.inst[0] = 0xffffffffu;
      rtcIntersect1(scene, &q, 0);
      found += q.geom != 0xffffffffu;
    }
  }
  double seconds = now() - start;
  *hits = found;
  return seconds;
}
