"""The paper's experiments, repeated; see tools/run_validation.py."""
