"""The benchmarking harness: parametric studies of scenes, archived and compared with references."""
