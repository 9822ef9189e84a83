"""Work in three steps: gather reads the scene, compute touches arrays only, write changes it."""
