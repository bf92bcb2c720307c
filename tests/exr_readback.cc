// Reads an OpenEXR file with tinyexr, which shares no code with the writer under test.
// usage: exr_readback FILE PIXELS
// Prints a line per part, channel and attribute, and writes all pixels as native floats to PIXELS:
//   part NUMBER NAME WIDTH HEIGHT
//   channel NUMBER NAME TYPE FIRST      (TYPE 1 half, 2 float; FIRST: index of its first float)
//   attribute NUMBER NAME TYPE VALUE    (double, string, and the count of a floatvector)
#include <cstdio>
#include <cstring>
#include <tinyexr.h>

static int fail(const char *what, const char *message) {
  fprintf(stderr, "exr_readback: %s: %s\n", what, message ? message : "failed");
  return 1;
}

static void print_attribute(int part, const EXRAttribute &a) {
  double number;
  if (strcmp(a.type, "double") == 0) {
    memcpy(&number, a.value, sizeof number);
    printf("attribute %d %s double %.17g\n", part, a.name, number);
  } else if (strcmp(a.type, "string") == 0) {
    printf("attribute %d %s string %.*s\n", part, a.name, a.size,
           reinterpret_cast<const char *>(a.value));
  } else if (strcmp(a.type, "floatvector") == 0) {
    printf("attribute %d %s floatvector %d\n", part, a.name, a.size / 4);
  } else {
    printf("attribute %d %s %s\n", part, a.name, a.type);
  }
}

int main(int argc, char **argv) {
  EXRVersion version;
  EXRHeader **headers = nullptr;
  const char *message = nullptr;
  int count = 0;
  if (argc != 3)
    return fail("usage", "exr_readback FILE PIXELS");
  if (ParseEXRVersionFromFile(&version, argv[1]) != TINYEXR_SUCCESS)
    return fail(argv[1], "no OpenEXR file");
  EXRHeader *single = new EXRHeader; // what the multi-part reader would have made of it
  InitEXRHeader(single);
  if (version.multipart ? ParseEXRMultipartHeaderFromFile(&headers, &count, &version, argv[1],
                                                          &message)
                        : ParseEXRHeaderFromFile(single, &version, argv[1], &message))
    return fail(argv[1], message);
  if (!version.multipart)
    headers = &single, count = 1;
  EXRImage *images = new EXRImage[count];
  for (int p = 0; p < count; p++) {
    InitEXRImage(&images[p]);
    for (int c = 0; c < headers[p]->num_channels; c++)
      headers[p]->requested_pixel_types[c] = TINYEXR_PIXELTYPE_FLOAT;
  }
  // Loading writes the requested types over the file's: print first.
  long first = 0;
  for (int p = 0; p < count; p++) {
    const EXRHeader *h = headers[p];
    int width = h->data_window.max_x - h->data_window.min_x + 1;
    int height = h->data_window.max_y - h->data_window.min_y + 1;
    printf("part %d %s %d %d\n", p, h->name, width, height);
    for (int c = 0; c < h->num_channels; c++, first += (long)width * height)
      printf("channel %d %s %d %ld\n", p, h->channels[c].name, h->channels[c].pixel_type, first);
    for (int a = 0; a < h->num_custom_attributes; a++)
      print_attribute(p, h->custom_attributes[a]);
  }
  if (version.multipart
          ? LoadEXRMultipartImageFromFile(images, const_cast<const EXRHeader **>(headers),
                                          static_cast<unsigned>(count), argv[1], &message)
          : LoadEXRImageFromFile(images, single, argv[1], &message))
    return fail(argv[1], message);
  FILE *pixels = fopen(argv[2], "wb");
  if (!pixels)
    return fail(argv[2], "cannot be written");
  for (int p = 0; p < count; p++)
    for (int c = 0; c < headers[p]->num_channels; c++)
      fwrite(images[p].images[c], sizeof(float), (size_t)images[p].width * images[p].height,
             pixels);
  int failed = fclose(pixels);
  for (int p = 0; p < count; p++) {
    FreeEXRImage(&images[p]);
    FreeEXRHeader(headers[p]);
    delete headers[p];
  }
  delete[] images;
  return failed ? fail(argv[2], "cannot be written") : 0;
}
