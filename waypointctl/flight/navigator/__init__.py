"""On board, between plan and policy: where the policy is to go now, and next."""
