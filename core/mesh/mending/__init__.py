"""Any triangle soup made an oriented manifold."""
