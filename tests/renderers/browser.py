"""Headless Chromium with WebGL 2 on the CPU."""
import shutil
import subprocess

COMMAND = ["chromium", "--headless", "--no-sandbox", "--use-angle=swiftshader",
           "--enable-unsafe-swiftshader", "--hide-scrollbars"]


def present():
    return shutil.which(COMMAND[0]) is not None


def chromium(*arguments):
    return subprocess.run(COMMAND + list(arguments), check=True, timeout=300, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout
